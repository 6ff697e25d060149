/* SPDX-License-Identifier: Apache-2.0 */
/* 64-bit addition, shifts, comparison, multiplication and division by the compiler library. */
#include "test.h"

void test(void) {
  for (int i = 0; i < 25; ++i) {
    uint64_t a = (uint64_t)draw() << 32 | draw(), b = ((uint64_t)draw() << 32 | draw()) >> draw_below(64);
    unsigned n = draw_below(64);
    if (b == 0) b = 9;
    add64(a + b);
    add64(a - b);
    add64(a * b);
    add64(a / b);
    add64(a % b);
    add64(a << n);
    add64(a >> n);
    add64((uint64_t)((int64_t)a >> n));
    add(a < b);
    add((int64_t)a < (int64_t)b);
    add64((uint64_t)((int64_t)a / (int64_t)(b >> 1 | 1)));
    add64((uint64_t)((int64_t)a % (int64_t)(b >> 1 | 1)));
  }
}
