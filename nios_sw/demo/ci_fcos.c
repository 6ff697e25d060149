/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fcos: cosine of a in radians.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fcos.sv; test: tests/custom. */
#include "ci_demo.h"

/* Through a pointer, else the compiler may put the instruction here too. */
static float (*volatile cosine)(float) = cosf;

int main(void) {
  int failed = 0;
#ifdef CI_FCOS_N
  DEMO("fcos", f, float, 1.2345f, int, 0, ci_fcos(a), cosine(a), CI_HARDWARE);
#else
  DEMO("fcos", f, float, 1.2345f, int, 0, cosine(a), cosine(a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
