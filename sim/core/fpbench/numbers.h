// SPDX-License-Identifier: Apache-2.0
// Numbers for the bench: the generator, special values, numbers from parts.
#pragma once
#include <algorithm>
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
  // Uniform in 0 .. n - 1 except for a bias below n / 2^32.
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

}  // namespace cases
