/* SPDX-License-Identifier: Apache-2.0 */
/* A first program of one's own: text, a custom instruction by plain C, its time. */
#include <math.h>
#include <stdio.h>

#include "io.h"

int main(void) {
  volatile float two = 2.0f;
  uint32_t begin = cycle_now();
  volatile float root = sqrtf(two);
  uint32_t cycles = cycle_now() - begin;

  printf("square root of %g on FPGA%lu: %.7f, %lu cycles\n", two, io_read(REG_PLATFORM), root,
         cycles);
  return 0;
}
