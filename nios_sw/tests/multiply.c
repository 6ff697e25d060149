/* SPDX-License-Identifier: Apache-2.0 */
/* 32 x 32 products, low and high words, signed, unsigned and mixed. */
#include "test.h"

void test(void) {
  static const uint32_t corner[] = {0, 1, 2, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xFFFFFFFF, 0x10000};
  for (unsigned i = 0; i < 8; ++i) {
    for (unsigned j = 0; j < 8; ++j) {
      uint32_t a = corner[i], b = corner[j];
      add(a * b);
      add64((uint64_t)a * b);
      add64((uint64_t)((int64_t)(int32_t)a * (int32_t)b));
      add64((uint64_t)((int64_t)(int32_t)a * (int64_t)(uint64_t)b));
      add(OPAQUE(a) * 37u);
      add(OPAQUE(a) * 0xFFFFFFF1u);
    }
  }
  for (int i = 0; i < 30; ++i) add64((uint64_t)draw() * draw());
}
