/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fixsi: float to integer, toward zero.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fixsi.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FIXSI_N
  DEMO("fixsi", i, float, -1234.75f, int, 0, ci_fixsi(a), SOFT_FIX(a), CI_HARDWARE);
#else
  DEMO("fixsi", i, float, -1234.75f, int, 0, SOFT_FIX(a), SOFT_FIX(a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
