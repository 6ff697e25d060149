// SPDX-License-Identifier: Apache-2.0
// Results and flags from the host's IEEE 754 arithmetic, checked against SoftFloat by selfcheck.py.
//
// The host's exception flags are cleared before and read after each operation; `pin` keeps the
// compiler from moving, merging or folding the operation in between. Conversions out of range, NaN
// results and the operations that IEEE 754 does not define follow the contracts stated in
// rtl/fpu/fp_pkg.sv and in the units' headers.
#pragma once
#include <cfenv>
#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace reference {

using u8 = uint8_t;
using u32 = uint32_t;
using u64 = uint64_t;

enum : u8 { NX = 1, UF = 2, OF = 4, DZ = 8, NV = 16 };  // order of fp_pkg::flags_t
constexpr u32 CANON_NAN = 0x7fc00000, SIGN = 0x80000000, INF = 0x7f800000, ONE = 0x3f800000;

struct Value {
  u32 bits;
  u8 flags;
};

inline float number(u32 bits) {
  float x;
  std::memcpy(&x, &bits, 4);
  return x;
}
inline u32 pattern(float x) {
  u32 bits;
  std::memcpy(&bits, &x, 4);
  return bits;
}
inline bool is_nan(u32 x) { return (x & ~SIGN) > INF; }
inline bool is_snan(u32 x) { return is_nan(x) && !(x & 0x00400000); }
inline bool is_inf(u32 x) { return (x & ~SIGN) == INF; }
inline bool is_zero(u32 x) { return !(x & ~SIGN); }

#if defined(__SSE2__)
template <class T> inline void pin(T &x) { asm volatile("" : "+x"(x)::"memory"); }
inline void clear_flags() { _mm_setcsr(0x1f80); }  // all masked, to nearest even, no flush to zero
inline u8 read_flags() {
  const unsigned s = _mm_getcsr();  // bits 0 invalid, 2 by zero, 3 overflow, 4 underflow, 5 inexact
  return u8((s & 1) << 4 | (s & 4) << 1 | (s & 8) >> 1 | (s & 16) >> 3 | (s & 32) >> 5);
}
#else
template <class T> inline void pin(T &x) {
  volatile T copy = x;
  x = copy;
}
inline void clear_flags() { std::feclearexcept(FE_ALL_EXCEPT); }
inline u8 read_flags() {
  const int s = std::fetestexcept(FE_ALL_EXCEPT);
  return u8((s & FE_INVALID ? NV : 0) | (s & FE_DIVBYZERO ? DZ : 0) | (s & FE_OVERFLOW ? OF : 0) |
            (s & FE_UNDERFLOW ? UF : 0) | (s & FE_INEXACT ? NX : 0));
}
#endif

// One host operation on pinned operands: float result bits, canonical NaN, and the flags it raised.
template <class F, class... X> inline Value host(F operation, X... x) {
  clear_flags();
  (pin(x), ...);
  float result = operation(x...);
  pin(result);
  const u8 flags = read_flags();
  const u32 bits = pattern(result);
  return {is_nan(bits) ? CANON_NAN : bits, flags};
}

// A host comparison: 1.0 or 0.0. `==` is quiet, `<` and `<=` signal on any NaN (IEEE 754, 5.6.1).
template <class F> inline Value host_compare(F operation, u32 a, u32 b) {
  float x = number(a), y = number(b);
  clear_flags();
  pin(x), pin(y);
  int truth = operation(x, y);
  asm volatile("" : "+r"(truth)::"memory");
  return {truth ? ONE : 0, u8(read_flags() & NV)};
}

inline Value add(u32 a, u32 b) {
  return host([](float x, float y) { return x + y; }, number(a), number(b));
}
inline Value mul(u32 a, u32 b) {
  return host([](float x, float y) { return x * y; }, number(a), number(b));
}
inline Value div(u32 a, u32 b) {
  return host([](float x, float y) { return x / y; }, number(a), number(b));
}
inline Value sqrt(u32 a) {
#if defined(__SSE2__)
  return host([](float x) { return _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))); }, number(a));
#else
  return host([](float x) { return std::sqrt(x); }, number(a));
#endif
}
inline Value mul_add(u32 a, u32 b, u32 c) {
  Value v =
      host([](float x, float y, float z) { return std::fma(x, y, z); }, number(a), number(b), number(c));
  // IEEE 754, 7.2 leaves 0 * inf + quiet NaN to the implementation; SoftFloat and our units signal.
  if ((is_zero(a) && is_inf(b)) || (is_inf(a) && is_zero(b))) v.flags = NV;
  return v;
}
inline Value signed_to_float(u32 a) {
  int32_t i = int32_t(a);
  clear_flags();
  asm volatile("" : "+r"(i)::"memory");
  float x = float(i);
  pin(x);
  return {pattern(x), read_flags()};
}
inline Value unsigned_to_float(u32 a) {
  int64_t i = a;
  clear_flags();
  asm volatile("" : "+r"(i)::"memory");
  float x = float(i);
  pin(x);
  return {pattern(x), read_flags()};
}
// A binary32 number is exact in double, and so are its integer neighbours below 2^53.
inline Value to_signed(u32 a, bool truncate) {
  if (is_nan(a)) return {0x7fffffff, NV};
  const double x = number(a), n = truncate ? std::trunc(x) : std::nearbyint(x);
  if (n >= 2147483648.0) return {0x7fffffff, NV};
  if (n < -2147483648.0) return {0x80000000, NV};
  return {u32(int32_t(n)), u8(n == x ? 0 : NX)};
}

// Selections, from the numbers as doubles and the words of fp_pkg.
inline double wide(u32 a) { return double(number(a)); }
inline u8 signalling(u32 a, u32 b = 0, u32 c = 0) {
  return is_snan(a) || is_snan(b) || is_snan(c) ? NV : 0;
}
inline Value extremum(u32 a, u32 b, bool smaller) {  // minimumNumber, maximumNumber; -0 < +0
  const u8 flags = signalling(a, b);
  if (is_nan(a) || is_nan(b)) return {is_nan(a) ? (is_nan(b) ? CANON_NAN : b) : a, flags};
  const double x = wide(a), y = wide(b);
  const bool below = x != y ? x < y : std::signbit(x) && !std::signbit(y);
  return {below == smaller ? a : b, flags};
}
inline Value signum(u32 a) {
  if (is_nan(a)) return {CANON_NAN, signalling(a)};
  const double x = wide(a);
  return {x > 0 ? ONE : x < 0 ? (SIGN | ONE) : 0, 0};
}
inline Value saturate(u32 a, u32 low, u32 high) {
  if (is_nan(a) || is_nan(low) || is_nan(high)) return {CANON_NAN, signalling(a, low, high)};
  if (wide(low) > wide(high)) return {CANON_NAN, NV};
  return {wide(a) < wide(low) ? low : wide(a) > wide(high) ? high : a, 0};
}

}  // namespace reference
