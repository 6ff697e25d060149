/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fmul: a * b.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fmul.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FMUL_N
  DEMO("fmul", f, float, 1.1f, float, -2.3f, ci_fmul(a, b), SOFT_MUL(a, b), CI_HARDWARE);
#else
  DEMO("fmul", f, float, 1.1f, float, -2.3f, SOFT_MUL(a, b), SOFT_MUL(a, b), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
