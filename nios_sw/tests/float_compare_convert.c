/* SPDX-License-Identifier: Apache-2.0 */
/* Single-precision comparisons and conversions from and to integers. */
#include "test.h"

void test(void) {
  static const float values[] = {0.0f, -0.0f, 1.0f, -1.0f, 0.5f, 1e9f, -2147483648.0f, 3e-39f, 16777217.0f};
  for (unsigned i = 0; i < 9; ++i) {
    for (unsigned j = 0; j < 9; ++j) {
      float a = OPAQUE(values[i]), b = values[j];
      add((uint32_t)(a < b) | (uint32_t)(a <= b) << 1 | (uint32_t)(a == b) << 2 |
          (uint32_t)(a > b) << 3 | (uint32_t)(a >= b) << 4 | (uint32_t)(a != b) << 5);
    }
    add((uint32_t)(int32_t)values[i]);
    add_double((double)values[i]);
    add64((uint64_t)(int64_t)values[i]);
  }
  for (int i = 0; i < 40; ++i) {
    uint32_t x = draw() >> draw_below(32);
    add_float((float)x);
    add_float((float)(int32_t)x);
    add_float((float)((uint64_t)x << 20));
    add_float((float)((int64_t)x * -33333));
  }
}
