/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fadd: a + b.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fadd.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FADD_N
  DEMO("fadd", f, float, 1.5f, float, 2.25f, ci_fadd(a, b), SOFT_ADD(a, b), CI_HARDWARE);
#else
  DEMO("fadd", f, float, 1.5f, float, 2.25f, SOFT_ADD(a, b), SOFT_ADD(a, b), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
