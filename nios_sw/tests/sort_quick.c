/* SPDX-License-Identifier: Apache-2.0 */
/* qsort and bsearch of the C library with several orders. */
#include <stdlib.h>

#include "test.h"

static int ascending(const void *a, const void *b) {
  int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
  return (x > y) - (x < y);
}
static int by_digits(const void *a, const void *b) {
  uint32_t x = *(const uint32_t *)a % 1000u, y = *(const uint32_t *)b % 1000u;
  return x != y ? (x > y) - (x < y) : ascending(a, b);
}

void test(void) {
  static int32_t values[150];
  for (unsigned i = 0; i < 150; ++i) values[i] = (int32_t)draw() >> 8;
  qsort(values, 150, sizeof values[0], ascending);
  for (unsigned i = 0; i < 150; ++i) add((uint32_t)values[i]);
  for (unsigned i = 0; i < 20; ++i) {
    int32_t key = i & 1 ? values[draw_below(150)] : (int32_t)draw();
    int32_t *at = bsearch(&key, values, 150, sizeof values[0], ascending);
    add(at ? (uint32_t)(at - values) : 0xFFFFu);
  }
  qsort(values, 150, sizeof values[0], by_digits);
  for (unsigned i = 0; i < 150; ++i) add((uint32_t)values[i]);
}
