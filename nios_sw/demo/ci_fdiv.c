/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fdiv: a / b.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fdiv.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FDIV_N
  DEMO("fdiv", f, float, 1.0f, float, 3.0f, ci_fdiv(a, b), SOFT_DIV(a, b), CI_HARDWARE);
#else
  DEMO("fdiv", f, float, 1.0f, float, 3.0f, SOFT_DIV(a, b), SOFT_DIV(a, b), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
