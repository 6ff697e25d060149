// SPDX-License-Identifier: Apache-2.0
// check of sine and cosine: error in ulp against the host's double-precision functions.
//
// glibc's sin and cos are below one ulp of double. A float's ulp is 2^29 of those in the same binade,
// so the error is known to better than 2^-28 of a float's ulp; sincos.py checks the worst cases
// against MPFR. The difference of result and reference is exact in double (Sterbenz).
#pragma once
#include "reference.h"

namespace angles {

using reference::u32;
using reference::u64;
using reference::u8;

constexpr u32 LIMIT = 0x43800000;  // 256 rad: beyond, NaN and nv by contract
constexpr int BINS = 64;           // of 1/64 ulp; the last takes everything from one ulp on

struct Statistics {
  u64 in_range = 0, beyond = 0, symmetric_pairs = 0, not_nearest = 0;
  double worst = 0;  // ulp
  u32 worst_at = 0, pad = 0;
  u64 histogram[BINS + 1] = {};
};

inline double exact(bool cosine, u32 a) {
  const double x = reference::number(a);
  return cosine ? std::cos(x) : std::sin(x);
}

inline double error_ulp(double exact, u32 result) {
  u64 bits;
  std::memcpy(&bits, &exact, 8);
  const int e = std::max(int(bits >> 52 & 2047) - 1023, -126);  // binade of the exact value
  const u64 scale_bits = u64(1023 + 23 - e) << 52;              // 2^(23 - e)
  double scale;
  std::memcpy(&scale, &scale_bits, 8);
  return std::fabs(double(reference::number(result)) - exact) * scale;
}

// Checks one result; false: wrong. `want` receives the reference's bits for the failure line.
inline bool judge(bool cosine, u32 a, u32 got, u8 got_flags, double bound, Statistics &s, u32 &want,
                  u8 &want_flags) {
  const u32 m = a & ~reference::SIGN;
  if (m > LIMIT) {
    s.beyond++;
    want = reference::CANON_NAN;
    want_flags = reference::is_nan(a) && !reference::is_snan(a) ? 0 : reference::NV;
    return got == want && got_flags == want_flags;
  }
  s.in_range++;
  if (m == 0) {
    want = cosine ? reference::ONE : a;
    want_flags = 0;
    s.histogram[0]++;
    return got == want && got_flags == want_flags;
  }
  const double y = exact(cosine, a);
  want = reference::pattern(float(y));
  want_flags = u8(reference::NX | (!cosine && m < 0x00800000 ? reference::UF : 0));
  if (reference::is_nan(got) || reference::is_inf(got)) return false;
  const double e = error_ulp(y, got);
  s.histogram[std::min(BINS, int(std::min(e, 2.0) * BINS))]++;
  s.not_nearest += got != want;
  if (e > s.worst) s.worst = e, s.worst_at = a;
  return e <= bound && got_flags == want_flags && (got >> 31) == (want >> 31);
}

}  // namespace angles
