// SPDX-License-Identifier: Apache-2.0
// Operands for the bench: cross products of special values, exponent-correlated random numbers, and
// hard cases constructed from congruences. Everything is a function of (operation, kind, index, seed).
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "operations.h"

namespace cases {

using operations::Family;
using operations::Operation;
using reference::SIGN;
using u32 = uint32_t;
using u64 = uint64_t;

// xoshiro256++ 1.0 (Blackman and Vigna 2019), seeded by splitmix64.
class Random {
 public:
  explicit Random(u64 seed) {
    for (u64 &word : state_) {
      u64 z = (seed += 0x9e3779b97f4a7c15u);
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
      word = z ^ (z >> 31);
    }
  }
  u64 next() {
    auto rotate = [](u64 x, int k) { return x << k | x >> (64 - k); };
    const u64 result = rotate(state_[0] + state_[3], 23) + state_[0], t = state_[1] << 17;
    state_[2] ^= state_[0], state_[3] ^= state_[1], state_[1] ^= state_[2], state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = rotate(state_[3], 45);
    return result;
  }
  u32 word() { return u32(next() >> 32); }
  // Uniform in 0 .. n - 1 but for a bias below n / 2^32.
  u32 below(u32 n) { return u32(u64(word()) * n >> 32); }
  int range(int low, int high) { return low + int(below(u32(high - low + 1))); }

 private:
  u64 state_[4];
};

// ---- special values: signs x exponents x significands; level 1 and level 2 ----
inline const std::vector<u32> &fractions(int level) {
  auto build = [](int level) {
    std::vector<u32> v{0, 1, 0x7fffff, 0x7ffffe};
    if (level == 2)
      for (int k = 0; k < 23; k++) {
        const u32 one = 1u << k, ones = (one << 1) - 1;
        for (u32 f : {one, 0x7fffffu ^ one, ones, 0x7fffffu ^ ones}) v.push_back(f);
      }
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
    return v;
  };
  static const std::vector<u32> v1 = build(1), v2 = build(2);
  return level == 1 ? v1 : v2;
}
inline const std::vector<u32> &specials(int level) {
  auto build = [](int level) {
    std::vector<u32> v;
    for (u32 sign : {0u, 1u})
      for (u32 e : {0u, 1u, 63u, 103u, 126u, 127u, 128u, 151u, 253u, 254u, 255u})
        for (u32 f : fractions(level)) v.push_back(sign << 31 | e << 23 | f);
    return v;
  };
  static const std::vector<u32> v1 = build(1), v2 = build(2);
  return level == 1 ? v1 : v2;
}

// ---- numbers from parts ----
inline u32 exponent(u32 x) { return x >> 23 & 255; }
// n 2^x with 0 < n < 2^24, exactly: x >= -149, and n 2^x < 2^128.
inline u32 scaled(u32 n, int x) {
  const int length = 32 - __builtin_clz(n), e = x + length - 1;
  if (e >= -126) return u32(e + 127) << 23 | ((n << (24 - length)) & 0x7fffff);
  return n << (x + 149);
}
inline u32 inverse_odd(u32 b) {  // b^-1 modulo 2^32, Newton: each step doubles the right bits
  u32 x = b;
  for (int i = 0; i < 4; i++) x *= 2 - b * x;
  return x;
}

inline u32 fraction(Random &g) {
  const u64 w = g.next();
  const u32 uniform = u32(w) & 0x7fffff, shift = u32(w >> 48) % 24, kind = u32(w >> 60);
  if (kind < 7) return uniform;
  const u32 sparse = uniform & u32(w >> 25) & u32(g.next());
  switch (kind) {
    case 7: case 8: return sparse;
    case 9: return sparse ^ 0x7fffff;
    case 10: case 11: return (0x7fffffu << shift) & 0x7fffff;  // 1..10..0
    case 12: return 0x7fffffu >> shift;                        // 0..01..1
    default: return (uniform << shift) & 0x7fffff;             // few significant bits
  }
}
inline u32 with_exponent(Random &g, int e) {  // biased, clipped to finite numbers
  return (g.word() & SIGN) | u32(std::clamp(e, 0, 254)) << 23 | fraction(g);
}
inline u32 finite(Random &g) {
  return with_exponent(g, g.below(16) ? int(g.below(255)) : 0);
}
inline u32 special(Random &g) {
  const auto &v = specials(2);
  return v[g.below(u32(v.size()))];
}
inline u32 nudged(Random &g, u32 x, int ulps) {
  const int m = std::clamp(int(x & ~SIGN) + g.range(-ulps, ulps), 0, 0x7f7fffff);
  return u32(m) | (x & SIGN);
}
inline u32 subnormal(Random &g) { return (g.word() & SIGN) | (fraction(g) >> g.below(23)); }

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

// ---- exponent-correlated random operands ----
inline void with_product_exponent(Random &g, int target, u32 &a, u32 &b) {
  const int e = g.range(std::max(1, target - 127), std::min(254, target + 126));
  a = with_exponent(g, e);
  b = with_exponent(g, std::max(1, target + 127 - e));
}
inline u32 rounded_product(u32 a, u32 b) {
  return reference::pattern(float(double(reference::number(a)) * double(reference::number(b))));
}
// a b with 25 significant bits at most: ties and exact products; target: biased exponent of a b.
inline void short_product(Random &g, int target, u32 &a, u32 &b) {
  const int bits = g.range(1, 24);
  const u32 m = (g.word() >> (32 - bits)) | 1, n = (g.word() >> (32 - (25 - bits))) | 1;
  const int x = g.range(-100, 100);
  const int y = std::clamp(target - 127 - 24 - x, -149, 104);
  a = scaled(m, std::clamp(x, -149, 104)) | (g.word() & SIGN);
  b = scaled(n, y) | (g.word() & SIGN);
}

inline void add_pair(Random &g, u32 &a, u32 &b) {
  a = finite(g);
  switch (g.below(8)) {
    case 0: a = special(g), b = special(g); return;
    case 1: b = with_exponent(g, g.range(0, 254)); return;
    case 2: case 3: b = with_exponent(g, int(exponent(a)) + g.range(-60, 60)); break;
    case 4: b = nudged(g, a, 3) ^ SIGN; return;
    case 5: b = with_exponent(g, int(exponent(a)) + g.range(-1, 1)); break;
    case 6: {  // b is an odd multiple of half an ulp of a, or just beside
      const int e = std::max(1, int(exponent(a)));
      b = with_exponent(g, e - 24 + g.range(0, 2)) & ~((1u << g.range(20, 23)) - 1);
      if (!g.below(4)) b ^= 1;
      return;
    }
    default: {  // around overflow, and in the subnormal range
      const bool high = g.word() & 1;
      a = with_exponent(g, high ? g.range(228, 254) : g.range(0, 26));
      b = with_exponent(g, high ? g.range(228, 254) : g.range(0, 26));
    }
  }
  if (g.word() & 1) std::swap(a, b);
}
inline void mul_pair(Random &g, u32 &a, u32 &b) {
  switch (g.below(8)) {
    case 0: a = special(g), b = special(g); return;
    case 1: a = finite(g), b = finite(g); return;
    case 2: with_product_exponent(g, g.range(250, 258), a, b); return;
    case 3: with_product_exponent(g, g.range(-27, 4), a, b); return;
    case 4: a = subnormal(g), b = with_exponent(g, g.range(96, 254)); break;
    case 5: short_product(g, g.range(2, 253), a, b); return;
    case 6: short_product(g, g.range(-26, 2), a, b); return;
    default: with_product_exponent(g, g.range(1, 254), a, b); return;
  }
  if (g.word() & 1) std::swap(a, b);
}
inline void div_pair(Random &g, u32 &a, u32 &b) {
  Case c;
  switch (g.below(8)) {
    case 0: a = special(g), b = special(g); return;
    case 1: a = finite(g), b = finite(g); return;
    case 2: case 3: case 4: {
      const int p = g.below(3) ? 24 : g.range(1, 23);
      if (hard_quotient(g, odd_number(g), small_remainder(g), p, p + int(g.below(2)), c)) {
        a = c.a, b = c.b;
        return;
      }
      [[fallthrough]];
    }
    case 5: {  // quotient around overflow or underflow
      const int target = g.word() & 1 ? g.range(251, 257) : g.range(-26, 3);  // biased
      const int e = g.range(std::max(0, target - 126), std::min(254, target + 127));
      a = with_exponent(g, e);
      b = with_exponent(g, e - target + 127);
      return;
    }
    case 6: a = subnormal(g), b = g.word() & 1 ? subnormal(g) : finite(g); break;
    default: {  // exact quotients and their neighbours
      u32 q;
      short_product(g, g.range(-20, 250), q, b);
      a = nudged(g, rounded_product(q, b), int(g.below(2)));
      return;
    }
  }
  if (g.word() & 1) std::swap(a, b);
}
inline void sqrt_operand(Random &g, u32 &a) {
  Case c;
  switch (g.below(4)) {
    case 0: a = g.word(); return;
    case 1: {
      const u32 q = with_exponent(g, g.range(64, 190));
      a = nudged(g, rounded_product(q, q), 2) & ~SIGN;
      return;
    }
    case 2:
      if (hard_root(g, int(g.below(1 << 20)) * 8 - (1 << 22) - 1, g.range(23, 26), int(g.below(4)), c)) {
        a = c.a;
        return;
      }
      [[fallthrough]];
    default: a = finite(g) & ~SIGN;
  }
}
inline void fma_triple(Random &g, u32 &a, u32 &b, u32 &c) {
  Case h;
  switch (g.below(10)) {
    case 0: a = special(g), b = special(g), c = special(g); return;
    case 1: a = finite(g), b = finite(g), c = finite(g); return;
    case 2: case 3:
      mul_pair(g, a, b);
      c = with_exponent(g, int(exponent(a)) + int(exponent(b)) - 127 + g.range(-60, 60));
      return;
    case 4: mul_pair(g, a, b), c = nudged(g, rounded_product(a, b) ^ SIGN, 2); return;
    case 5: {
      if (hard_cancellation(g, odd_number(g), small_remainder(g), g.below(2), h)) {
        a = h.a, b = h.b, c = h.c;
        if (!g.below(4)) c = nudged(g, c, 1);
        return;
      }
      [[fallthrough]];
    }
    case 6:  // around overflow
      with_product_exponent(g, g.range(250, 258), a, b);
      c = with_exponent(g, g.range(225, 254));
      return;
    case 7: {  // around and below the least normal number
      with_product_exponent(g, g.range(-50, 28), a, b);
      c = g.below(3) ? with_exponent(g, g.range(0, 28)) : nudged(g, rounded_product(a, b) ^ SIGN, 4);
      return;
    }
    case 8: {  // c halfway between two sums or next to it: a short product far below an even number
      c = with_exponent(g, g.range(1, 254));
      short_product(g, int(exponent(c)) - g.range(22, 28), a, b);
      return;
    }
    default: {  // sticky alone decides: tiny product against a tie of c with nothing else
      c = with_exponent(g, g.range(0, 254));
      with_product_exponent(g, int(exponent(c)) - g.range(20, 80), a, b);
      return;
    }
  }
}
inline void compared(Random &g, u32 &a, u32 &b, u32 &c) {
  a = g.below(4) ? finite(g) : special(g);
  auto other = [&] {
    switch (g.below(8)) {
      case 0: return special(g);
      case 1: return a;
      case 2: return a ^ SIGN;
      case 3: return g.word();
      case 4: case 5: return nudged(g, a & 0x7fffffff, 2) | (a & SIGN);
      default: return finite(g);
    }
  };
  b = other();
  c = other();
  if (g.below(2)) std::swap(a, g.below(2) ? b : c);
}
inline u32 integer(Random &g) {
  const u32 w = g.word() >> g.below(32);
  switch (g.below(4)) {
    case 0: return g.word();
    case 1: return 0 - w;
    case 2: return (w & ~((1u << g.below(24)) - 1)) + u32(g.range(-1, 1));
    default: return w;
  }
}

inline void random_case(Family family, Random &g, u32 &a, u32 &b, u32 &c) {
  if (!g.below(16)) {  // any bits
    a = g.word(), b = g.word(), c = g.word();
    return;
  }
  switch (family) {
    case Family::Add: add_pair(g, a, b); break;
    case Family::Mul: mul_pair(g, a, b); break;
    case Family::Div: div_pair(g, a, b); break;
    case Family::Sqrt: sqrt_operand(g, a); break;
    case Family::Fma: fma_triple(g, a, b, c); break;
    case Family::Compare: compared(g, a, b, c); break;
    case Family::Integer: a = integer(g), b = integer(g); break;
    case Family::ToInteger: a = with_exponent(g, g.range(120, 162)); break;
    case Family::Angle: a = g.below(8) ? with_exponent(g, g.range(111, 134)) : special(g); break;
  }
}

// ---- enumerated kinds ----
constexpr int REMAINDERS = 16;            // +-1 .. +-8
constexpr u64 ODD_NUMBERS = 1u << 22;     // odd significands of 24 bits
constexpr u64 ROOT_RESIDUES = 1u << 18;   // s = 8 i - 1 on both sides of zero

inline int remainder(u64 i) { return i & 1 ? -int(i / 2) - 1 : int(i / 2) + 1; }

// Cases an enumerated kind holds (upper limit for `hard`, which skips what has no solution);
// zero: the operation has no such kind. `random` has no end.
inline u64 size(const Operation &o, const std::string &kind) {
  auto power = [&](u64 n) { return o.operands == 1 ? n : o.operands == 2 ? n * n : n * n * n; };
  if (kind == "level1") return power(specials(1).size());
  if (kind == "level2") return power(specials(2).size());
  if (kind == "exhaustive" && o.operands == 1) return u64(1) << 32;
  if (kind == "hard" && o.family == Family::Div) return ODD_NUMBERS * REMAINDERS * 4;
  if (kind == "hard" && o.family == Family::Fma) return ODD_NUMBERS * REMAINDERS * 2;
  if (kind == "hard" && o.family == Family::Sqrt) return ROOT_RESIDUES * 16;
  if (kind == "random") return ~u64(0);
  return 0;
}

class Source {
 public:
  Source(const Operation &o, const std::string &kind, u64 start, u64 count, u64 seed)
      : o_(o), kind_(kind[0] == 'l' ? kind.back() : kind[0]), index_(start), end_(start + count),
        random_(seed * 0x9e3779b97f4a7c15u ^ start * 0xd1342543de82ef95u ^ hash(kind + o.name)) {}

  // Up to n further cases; less only at the end.
  u64 fill(u64 n, u32 *a, u32 *b, u32 *c) {
    u64 i = 0;
    if (kind_ == 'r')
      for (; i < n && index_ < end_; i++, index_++) random_case(o_.family, random_, a[i], b[i], c[i]);
    else if (kind_ == 'e')  // a number and its negative are neighbours: symmetry is checked in pairs
      for (; i < n && index_ < end_; i++, index_++) a[i] = u32(index_ >> 1) | u32(index_ << 31);
    else if (kind_ == 'h') {
      Case h;
      for (; i < n && index_ < end_; index_++)
        if (hard(index_, h)) a[i] = h.a, b[i] = h.b, c[i] = h.c, i++;
    } else {
      const auto &v = specials(kind_ - '0');
      const u64 m = v.size();
      for (; i < n && index_ < end_; i++, index_++) {
        a[i] = v[index_ % m];
        b[i] = v[index_ / m % m];
        c[i] = v[index_ / m / m % m];
      }
    }
    return i;
  }

 private:
  static u64 hash(const std::string &text) {  // FNV-1a
    u64 h = 0xcbf29ce484222325u;
    for (unsigned char x : text) h = (h ^ x) * 0x100000001b3u;
    return h;
  }
  bool hard(u64 i, Case &out) {
    const u64 j = i / REMAINDERS;
    const int r = remainder(i % REMAINDERS);
    const u32 b = u32(j % ODD_NUMBERS) << 1 | 1u << 23 | 1;
    const int variant = int(j / ODD_NUMBERS);
    switch (o_.family) {
      case Family::Div: {  // normal results above and below one; subnormal; short divisors
        if (variant < 2) return hard_quotient(random_, b, r, 24, 24 + variant, out);
        const int p = variant == 2 ? random_.range(1, 23) : 24;
        const u32 d = variant == 2 ? b : (b >> random_.range(1, 23)) | 1;
        return hard_quotient(random_, d, r, p, p + int(random_.below(2)), out);
      }
      case Family::Fma: return hard_cancellation(random_, b, r, variant == 1, out);
      case Family::Sqrt: {
        const int s = (int(i >> 4) - int(ROOT_RESIDUES / 2)) * 8 - 1;
        return hard_root(random_, s, 23 + int(i >> 2 & 3), int(i & 3), out);
      }
      default: return false;
    }
  }

  const Operation &o_;
  const char kind_;  // r, e, h, 1, 2
  u64 index_;
  const u64 end_;
  Random random_;
};

}  // namespace cases
