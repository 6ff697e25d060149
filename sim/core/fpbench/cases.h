// SPDX-License-Identifier: Apache-2.0
// Operands for the bench: cross products of special values, exponent-correlated random numbers, and
// hard cases constructed from congruences. Everything is a function of (operation, kind, index, seed).
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "hard_cases.h"

namespace cases {

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
    case 6: {  // b is an odd multiple of half an ulp of a, or just next to
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
