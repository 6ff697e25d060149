/* SPDX-License-Identifier: Apache-2.0 */
/* Horner schemes and Newton steps in single precision, one rounding per operation. */
#include "test.h"

void test(void) {
  static const float c[] = {1.0f, -0.5f, 0.25f, -0.125f, 0.0625f, 3.0f};
  for (int i = -20; i <= 20; ++i) {
    float x = (float)i * 0.07f, p = 0.0f;
    for (int k = 5; k >= 0; --k) p = p * x + c[k];
    add_float(p);
    float r = 1.0f;
    float a = p * p + 1.0f;
    for (int k = 0; k < 6; ++k) r = 0.5f * (r + a / r);
    add_float(r);
  }
}
