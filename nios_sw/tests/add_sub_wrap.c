/* SPDX-License-Identifier: Apache-2.0 */
/* Integer addition and subtraction modulo 2^32, signed and unsigned comparison. */
#include "test.h"

void test(void) {
  for (int i = 0; i < 60; ++i) {
    uint32_t a = draw(), b = i % 5 == 0 ? 0x80000000u : draw();
    add(a + b);
    add(a - b);
    add(a < b);
    add((int32_t)a < (int32_t)b);
    add(a == b || a >= b);
    add((int32_t)a <= (int32_t)b);
  }
}
