/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fsin: sine of a in radians.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fsin.sv; test: tests/custom. */
#include "ci_demo.h"

/* Through a pointer, else the compiler may put the instruction here too. */
static float (*volatile sine)(float) = sinf;

int main(void) {
  int failed = 0;
#ifdef CI_FSIN_N
  DEMO("fsin", f, float, 1.2345f, int, 0, ci_fsin(a), sine(a), CI_HARDWARE);
#else
  DEMO("fsin", f, float, 1.2345f, int, 0, sine(a), sine(a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
