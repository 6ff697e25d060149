/* SPDX-License-Identifier: Apache-2.0 */
/* What happens at an exception that nothing handles: a misaligned access ends the program. */
#include <stdio.h>

#include "io.h"

int main(void) {
  static uint32_t words[2];
  uint32_t *volatile odd = (uint32_t *)((uintptr_t)words + 2);

  printf("this text has no end of line");
  *odd = 1;
  printf("never reached\n");
  return 0;
}
