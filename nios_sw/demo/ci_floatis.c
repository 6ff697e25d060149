/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction floatis: integer to float.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_floatis.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FLOATIS_N
  DEMO("floatis", f, int, -123456789, int, 0, ci_floatis(a), SOFT_FLOAT(a), CI_HARDWARE);
#else
  DEMO("floatis", f, int, -123456789, int, 0, SOFT_FLOAT(a), SOFT_FLOAT(a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
