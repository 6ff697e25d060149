// SPDX-License-Identifier: Apache-2.0
// Hard cases of the bench, constructed from congruences.
#pragma once
#include "numbers.h"

namespace cases {

struct Case {
  u32 a = 0, b = 0, c = 0;
};

// ---- hard cases from congruences; false: no case with these parameters ----

// Division: a 2^k = b Q + r with b odd and Q of p + 1 bits. The quotient Q / 2^k misses a midpoint
// between p-bit numbers (r odd, so Q odd) or a p-bit number (r even) by |r| / b of the last place of
// Q. Modulo 2^k that is Q = -r b^-1. For p = 24 the result is normal; for less the exponents make it
// a subnormal number that has p significant bits.
inline bool hard_quotient(Random &g, u32 b, int r, int p, int k, Case &out) {
  u64 q = (0u - u32(r)) * inverse_odd(b) & ((u64(1) << k) - 1);
  if (k == p) q += u64(1) << p;
  if (!(q >> p)) return false;
  const int64_t n = int64_t(u64(b) * q) + r;
  if (n <= 0) return false;
  const u64 a = u64(n) >> k;
  if (!a || a >> 24 || (a << k) != u64(n)) return false;
  int x, y;
  if (p == 24) {  // last place of the result, 2^(x - y - k + 1), between those of normal numbers
    y = g.range(-149, 104);
    const int low = std::max(-149, y + k - 150), high = std::min(104, y + k + 103);
    if (low > high) return false;
    x = g.range(low, high);
  } else {
    y = g.range(1 - k, std::min(104, 254 - k));
    x = y + k - 150;
  }
  const u64 signs = g.next();
  out.a = scaled(u32(a), x) | (u32(signs) & SIGN);
  out.b = scaled(b, y) | (u32(signs >> 32) & SIGN);
  return true;
}

// Square root: m 2^k = Q^2 + s. Q of 25 bits and odd: the root misses a midpoint by s / 2Q of half an
// ulp; Q of 24 bits: it misses a binary32 number. Odd squares are 1 modulo 8; for such a residue four
// roots modulo 2^k exist, lifted bit by bit: if Q^2 = t modulo 2^j but not 2^(j+1), then
// (Q + 2^(j-1))^2 = t modulo 2^(j+1). The other three are -Q, Q + 2^(k-1) and its negative.
inline bool hard_root(Random &g, int s, int k, int which, Case &out) {
  const int bits = k >= 25 ? 25 : 24;
  const u64 t = u64(0) - u64(int64_t(s)), mask = (u64(1) << k) - 1;
  if ((t & 7) != 1) return false;
  u64 q = 1;
  for (int j = 3; j < k; j++)
    if ((q * q - t) >> j & 1) q += u64(1) << (j - 1);
  if (which & 1) q = 0 - q;
  if (which & 2) q += u64(1) << (k - 1);
  q &= mask;
  if (k < bits) q |= u64(1) << k;  // k = 24 or 25: Q has one bit more than the modulus
  if (q >> (bits - 1) != 1) return false;
  const u64 n = q * q + u64(int64_t(s)), m = n >> k;
  if (m >> 24 || !(m >> 23) || (m << k) != n) return false;
  const int parity = k & 1;  // the root of m 2^x is exact in 2^(x/2) only if x has the parity of k
  const int x = g.range(-74, 51) * 2 + parity;
  if (x < -149 || x > 104) return false;
  out.a = scaled(u32(m), x);
  return true;
}

// Fused multiply-add: a = r b^-1 modulo 2^24, so a b = C 2^24 + r with r of a few bits, and c takes
// all but r away. Edge: the remainder lies around or below the last place of the subnormal numbers.
inline bool hard_cancellation(Random &g, u32 b, int r, bool edge, Case &out) {
  const u32 a = u32(r) * inverse_odd(b) & 0xffffff;
  if (!a) return false;
  const int64_t product = int64_t(u64(a) * b);
  const u64 c = u64(product - r) >> 24;
  if (!c || c >> 24) return false;
  const int sum = edge ? g.range(-172, -140) : g.range(-140, 80);  // exponent of the product's unit
  const int low = std::max(-149, sum - 104), high = std::min(104, sum + 149);
  const int x = g.range(low, high);
  const u64 signs = g.next();
  const u32 sa = u32(signs) & SIGN, sb = u32(signs >> 32) & SIGN;
  out.a = scaled(a, x) | sa;
  out.b = scaled(b, sum - x) | sb;
  out.c = scaled(u32(c), sum + 24) | (sa ^ sb ^ SIGN);
  return true;
}

inline u32 odd_number(Random &g) {  // odd, of 1 to 24 bits, mostly 24
  const u32 full = g.word() >> 8 | 1u << 23 | 1;
  return g.below(4) ? full : (full >> g.below(24)) | 1;
}
inline int small_remainder(Random &g) {
  const int r = 1 + int(g.below(g.below(4) ? 8 : 4096));
  return g.word() & 1 ? r : -r;
}

}  // namespace cases
