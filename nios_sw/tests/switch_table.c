/* SPDX-License-Identifier: Apache-2.0 */
/* Dense and sparse switches, fall-through, nested loops with breaks. */
#include "test.h"

static __attribute__((noinline)) uint32_t dense(uint32_t k, uint32_t v) {
  switch (k) {
    case 0: return v + 1;
    case 1: return v * 3;
    case 2: v ^= 0x55;
    /* fall through */
    case 3: return v - 9;
    case 4: return ~v;
    case 5: return v >> 3;
    case 6: return v << 5;
    case 7: return v / 5;
    default: return k;
  }
}

static __attribute__((noinline)) uint32_t sparse(uint32_t k) {
  switch (k) {
    case 3: return 1;
    case 1000: return 2;
    case 77777: return 3;
    case 0xFFFFFFF0u: return 4;
    default: return 5;
  }
}

void test(void) {
  static const uint32_t keys[] = {3, 1000, 77777, 0xFFFFFFF0u, 4, 999};
  uint32_t v = 77;
  for (uint32_t i = 0; i < 120; ++i) add(v = dense(draw_below(10), v + i));
  for (unsigned i = 0; i < 6; ++i) add(sparse(OPAQUE(keys[i])));
  for (uint32_t i = 2; i < 60; ++i) {
    uint32_t j = 2;
    for (;; ++j) {
      if (j * j > i) break;
      if (i % j == 0) goto composite;
    }
    add(i);
  composite:;
  }
}
