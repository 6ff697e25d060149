/* SPDX-License-Identifier: Apache-2.0 */
/* The four operations of both platforms, and how the vendor's (FPH1) differ from ours: a subnormal
 * result is zero there. Instructions: nios_sw/custom.toml; hardware: rtl/custom/ci_fph1.sv (FPGA1),
 * ci_fadd, ci_fsub, ci_fmul, ci_fdiv (FPGA2); test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
  volatile float smallest = 1.17549435e-38f;
  DEMO("fmul", f, float, 1.1f, float, -2.3f, ci_fmul(a, b), SOFT_MUL(a, b), CI_HARDWARE);
  DEMO("fadd", f, float, 1.5f, float, 2.25f, ci_fadd(a, b), SOFT_ADD(a, b), CI_HARDWARE);
  DEMO("fsub", f, float, 1.5f, float, 2.25f, ci_fsub(a, b), SOFT_SUB(a, b), CI_HARDWARE);
  DEMO("fdiv", f, float, 1.0f, float, 3.0f, ci_fdiv(a, b), SOFT_DIV(a, b), CI_HARDWARE);
  console_text(demo_word_f(ci_fmul(smallest, 0.5f)) ? "subnormal result: kept\n"
                                                    : "subnormal result: zero\n");
  program_exit((uint32_t)failed);
  return failed;
}
