/* SPDX-License-Identifier: Apache-2.0 */
/* snprintf of integers: widths, flags, precisions, bases, two halves of 64 bits. */
#include <stdio.h>

#include "test.h"

void test(void) {
  char text[120];
  for (int i = 0; i < 12; ++i) {
    int32_t a = (int32_t)draw() >> draw_below(30);
    uint64_t b = ((uint64_t)draw() << 32 | draw()) >> draw_below(60);
    int n = snprintf(text, sizeof text, "%d|%8d|%-8d|%+d|%08d|% d|%.5d", (int)a, (int)a, (int)a,
                     (int)a, (int)a, (int)a, (int)(a % 1000));
    add((uint32_t)n);
    add_text(text);
    n = snprintf(text, sizeof text, "%x|%#X|%o|%#o|%u", (unsigned)a, (unsigned)a, (unsigned)a,
                 (unsigned)a, (unsigned)a);
    add((uint32_t)n);
    add_text(text);
    n = snprintf(text, sizeof text, "%d|%u|%x|%c|%s|%5.2s|%%", (int)(b >> 32), (unsigned)b,
                 (unsigned)(b >> 7), 'A' + i, "text", "abc");
    add((uint32_t)n);
    add_text(text);
    n = snprintf(text, OPAQUE((size_t)9), "%d cut off here", (int)a);
    add((uint32_t)n);
    add_text(text);
  }
}
