/* SPDX-License-Identifier: Apache-2.0 */
/* Bitwise operations with registers and with immediates of every form. */
#include "test.h"

void test(void) {
  for (int i = 0; i < 40; ++i) {
    uint32_t a = draw(), b = draw();
    add(a & b);
    add(a | b);
    add(a ^ b);
    add(~(a | b));
    add(a & 0xFFFFu);
    add(a & 0xFFFF0000u);
    add(a | 0x8000u);
    add(a | 0x80000000u);
    add(a ^ 0xFFFFu);
    add(a ^ 0xABCD0000u);
    add(a & 0x12345678u);
  }
}
