/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fsign: -1, 0 or 1.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fsign.sv; test: tests/custom. */
#include "ci_demo.h"

static float sign(float a) {
  return soft_less(0.0f, a) ? 1.0f : soft_less(a, 0.0f) ? -1.0f : 0.0f;
}

int main(void) {
  int failed = 0;
#ifdef CI_FSIGN_N
  DEMO("fsign", f, float, -0.25f, int, 0, ci_fsign(a), sign(a), CI_HARDWARE);
#else
  DEMO("fsign", f, float, -0.25f, int, 0, sign(a), sign(a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
