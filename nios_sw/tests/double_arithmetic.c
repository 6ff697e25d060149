/* SPDX-License-Identifier: Apache-2.0 */
/* Double-precision arithmetic in soft float. */
#include <math.h>
#include <string.h>

#include "test.h"

void test(void) {
  double a = 1.0, b = 3.0;
  for (int i = 0; i < 50; ++i) {
    uint64_t x = (uint64_t)draw() << 32 | draw(), y = (uint64_t)draw() << 32 | draw();
    if (i % 3 == 0) {
      memcpy(&a, &x, 8);
      memcpy(&b, &y, 8);
    } else {
      a = (double)(int64_t)x;
      b = (double)y / 4294967296.0;
    }
    add_double(a + b);
    add_double(a - b);
    add_double(a * b);
    add_double(a / b);
    add_float((float)a);
    add((uint32_t)(a < b) | (uint32_t)(a == b) << 1);
  }
  add_double(floor(OPAQUE(-2.5)) + ceil(OPAQUE(2.25)) + trunc(OPAQUE(-7.75)) + fabs(OPAQUE(-1.0)));
  add_double(ldexp(OPAQUE(0.75), 40));
  int exponent;
  add_double(frexp(OPAQUE(1234.5), &exponent));
  add((uint32_t)exponent);
  add_double(fmod(OPAQUE(100.25), 7.5));
}
