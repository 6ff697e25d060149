/* SPDX-License-Identifier: Apache-2.0 */
/* Q15 and Q31 arithmetic with saturation, a CORDIC rotation. */
#include "test.h"

static int32_t saturated(int64_t x) {
  return x > INT32_MAX ? INT32_MAX : x < INT32_MIN ? INT32_MIN : (int32_t)x;
}

void test(void) {
  static const int32_t angle[] = {16384, 9672, 5110, 2594, 1302, 652, 326, 163, 81, 41, 20, 10, 5};
  for (int k = -4; k <= 4; ++k) {
    int32_t x = 19898, y = 0, z = k * 5000;
    for (int i = 0; i < 13; ++i) {
      int32_t dx = y >> i, dy = x >> i;
      if (z >= 0) {
        x -= dx, y += dy, z -= angle[i];
      } else {
        x += dx, y -= dy, z += angle[i];
      }
    }
    add((uint32_t)x);
    add((uint32_t)y);
  }
  int32_t total = 0;
  for (int i = 0; i < 60; ++i) {
    int32_t a = (int32_t)draw(), b = (int32_t)draw();
    total = saturated((int64_t)total + ((int64_t)a * b >> 31));
    add((uint32_t)total);
  }
}
