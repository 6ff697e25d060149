/* SPDX-License-Identifier: Apache-2.0 */
/* memcpy, memmove, memset, memcmp, memchr at every alignment and length. */
#include <string.h>

#include "test.h"

void test(void) {
  static uint8_t from[48], to[48];
  for (unsigned i = 0; i < 48; ++i) from[i] = (uint8_t)draw();
  for (unsigned a = 0; a < 5; ++a) {
    for (unsigned n = 0; n < 23; n += 3) {
      memset(to + a, (int)n, 40);
      memcpy(to + 4 - a, from + a, n);
      memmove(to + a + 1, to + a, n);
      memmove(to + 3, to + 5, n + 7);
      add_bytes(to, sizeof to);
      add(memcmp(to, from, n) == 0);
      add(memcmp(to + 1, from + 1, n + 1) < 0);
      const uint8_t *at = memchr(to, from[n], 40);
      add(at ? (uint32_t)(at - to) : 99u);
    }
  }
}
