/* SPDX-License-Identifier: Apache-2.0 */
/* snprintf of doubles: fixed, scientific, general. */
#include <stdio.h>

#include "test.h"

void test(void) {
  static const double values[] = {0.0, -0.0, 1.0, -2.5, 3.141592653589793, 1e-5, 6.02e23, 999999.5};
  char text[100];
  for (unsigned i = 0; i < 8; ++i) {
    snprintf(text, sizeof text, "%f|%.3f|%e|%g", values[i], values[i], values[i], values[i]);
    add_text(text);
  }
  snprintf(text, sizeof text, "%10.4f|%-12.2e|%+.1f", values[4], values[6], values[3]);
  add_text(text);
}
