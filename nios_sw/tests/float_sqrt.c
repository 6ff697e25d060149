/* SPDX-License-Identifier: Apache-2.0 */
/* Single- and double-precision square roots, which are correctly rounded everywhere. */
#include <math.h>
#include <string.h>

#include "test.h"

void test(void) {
  for (int i = 0; i < 40; ++i) {
    uint32_t x = draw() & 0x7FFFFFFFu;
    float a;
    memcpy(&a, &x, 4);
    add_float(sqrtf(a));
    if (i % 4 == 0) add_double(sqrt((double)a));
  }
  add_float(sqrtf(OPAQUE(-1.0f)));
  add_float(sqrtf(OPAQUE(-0.0f)));
  add_float(sqrtf(OPAQUE(INFINITY)));
}
