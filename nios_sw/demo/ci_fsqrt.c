/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fsqrt: square root of a.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fsqrt.sv; test: tests/custom. */
#include "ci_demo.h"

/* Through a pointer, else the compiler puts the instruction here too. */
static float (*volatile root)(float) = sqrtf;

int main(void) {
  int failed = 0;
#ifdef CI_FSQRT_N
  DEMO("fsqrt", f, float, 2.0f, int, 0, ci_fsqrt(a), root(a), CI_HARDWARE);
#else
  DEMO("fsqrt", f, float, 2.0f, int, 0, root(a), root(a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
