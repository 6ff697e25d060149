/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fsub: a - b.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fsub.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FSUB_N
  DEMO("fsub", f, float, 1.5f, float, 2.25f, ci_fsub(a, b), SOFT_SUB(a, b), CI_HARDWARE);
#else
  DEMO("fsub", f, float, 1.5f, float, 2.25f, SOFT_SUB(a, b), SOFT_SUB(a, b), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
