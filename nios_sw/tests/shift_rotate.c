/* SPDX-License-Identifier: Apache-2.0 */
/* Shifts and rotations by every count. */
#include "test.h"

void test(void) {
  for (uint32_t n = 0; n < 32; ++n) {
    uint32_t a = draw(), m = OPAQUE(n);
    add(a << m);
    add(a >> m);
    add((uint32_t)((int32_t)a >> m));
    add(a << m | a >> ((32 - m) & 31));
    add(a >> m | a << ((32 - m) & 31));
  }
  add(OPAQUE(0x80000001u) << 7);
  add((uint32_t)(OPAQUE((int32_t)0x80000001) >> 31));
}
