/* SPDX-License-Identifier: Apache-2.0 */
/* Quotients and remainders, signed and unsigned, of defined operands. */
#include "test.h"

void test(void) {
  for (int i = 0; i < 60; ++i) {
    uint32_t a = draw(), b = draw() >> draw_below(32);
    if (b == 0) b = 3;
    add(a / b);
    add(a % b);
    int32_t s = (int32_t)a, t = (int32_t)b;
    if (i & 1) t = -t;
    if (t == 0 || (t == -1 && s == INT32_MIN)) t = 7;
    add((uint32_t)(s / t));
    add((uint32_t)(s % t));
    add(a / 10u);
    add((uint32_t)(s / 7));
    add((uint32_t)(s / 8));
  }
}
