/* SPDX-License-Identifier: Apache-2.0 */
/* malloc, calloc, realloc and free in random order. */
#include <stdlib.h>
#include <string.h>

#include "test.h"

enum { BLOCKS = 24 };

void test(void) {
  static uint8_t *block[BLOCKS];
  static uint32_t size[BLOCKS];
  for (int step = 0; step < 160; ++step) {
    uint32_t i = draw_below(BLOCKS);
    if (!block[i]) {
      size[i] = 1 + draw_below(200);
      block[i] = step & 1 ? calloc(size[i], 1) : malloc(size[i]);
      if (!block[i]) return;
      if (!(step & 1)) memset(block[i], (int)i, size[i]);
    } else if (step % 3 == 0) {
      uint32_t bigger = size[i] + draw_below(100);
      uint8_t *moved = realloc(block[i], bigger);
      if (!moved) return;
      memset(moved + size[i], step, bigger - size[i]);
      block[i] = moved;
      size[i] = bigger;
    } else {
      add_bytes(block[i], size[i]);
      free(block[i]);
      block[i] = NULL;
    }
  }
}
