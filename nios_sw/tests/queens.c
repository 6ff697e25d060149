/* SPDX-License-Identifier: Apache-2.0 */
/* The eight queens by backtracking, with bit sets. */
#include "test.h"

static uint32_t solutions;

static void place(uint32_t columns, uint32_t left, uint32_t right, uint32_t all) {
  if (columns == all) {
    ++solutions;
    return;
  }
  for (uint32_t open = all & ~(columns | left | right); open;) {
    uint32_t bit = open & -open;
    open ^= bit;
    place(columns | bit, (left | bit) << 1, (right | bit) >> 1, all);
  }
}

void test(void) {
  for (uint32_t n = 4; n <= 6; ++n) {
    solutions = 0;
    place(0, 0, 0, (1u << n) - 1);
    add(solutions);
  }
}
