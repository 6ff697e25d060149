/* SPDX-License-Identifier: Apache-2.0 */
/* Population count, leading and trailing zeros, byte reversal, parity by the compiler library. */
#include "test.h"

void test(void) {
  for (int i = 0; i < 40; ++i) {
    uint32_t a = draw() >> draw_below(32);
    a |= 1u << draw_below(32);
    uint64_t b = (uint64_t)draw() << 32 | a;
    add((uint32_t)__builtin_popcount(a));
    add((uint32_t)__builtin_clz(a));
    add((uint32_t)__builtin_ctz(a));
    add((uint32_t)__builtin_parity(a));
    add((uint32_t)__builtin_ffs((int)a));
    add(__builtin_bswap32(a));
    add64(__builtin_bswap64(b));
    add((uint32_t)__builtin_popcountll(b));
    add((uint32_t)__builtin_clzll(b));
    add((uint32_t)__builtin_ctzll(b));
  }
}
