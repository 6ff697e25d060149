/* SPDX-License-Identifier: Apache-2.0 */
/* Single-precision sums and differences in soft float, corner cases included. */
#include <string.h>

#include "test.h"

void test(void) {
  static const uint32_t corner[] = {0,          0x80000000, 1,          0x007FFFFF, 0x00800000, 0x3F800000,
                                    0xBF800000, 0x7F7FFFFF, 0x7F800000, 0xFF800000, 0x7FC00000, 0x33800000};
  for (unsigned i = 0; i < 12; ++i) {
    for (unsigned j = 0; j < 12; ++j) {
      float a, b;
      memcpy(&a, &corner[i], 4);
      memcpy(&b, &corner[j], 4);
      add_float(OPAQUE(a) + b);
      add_float(OPAQUE(a) - b);
    }
  }
  for (int i = 0; i < 60; ++i) {
    uint32_t x = draw(), y = draw();
    if (i & 1) y = (x & 0xFF800000u) + (draw() & 0x01FFFFFFu);
    float a, b;
    memcpy(&a, &x, 4);
    memcpy(&b, &y, 4);
    add_float(a + b);
    add_float(a - b);
  }
}
