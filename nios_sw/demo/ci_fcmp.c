/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instructions of ci_fcmp: comparisons, minimum, maximum, magnitude, negation.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fcmp.sv; test: tests/custom. */
#include "ci_demo.h"

int main(void) {
  int failed = 0;
#ifdef CI_FCMPLT_N
  DEMO("fcmplt", i, float, -1.5f, float, 2.5f, ci_fcmplt(a, b), soft_less(a, b), CI_HARDWARE);
#else
  DEMO("fcmplt", i, float, -1.5f, float, 2.5f, soft_less(a, b), soft_less(a, b), 0);
#endif
#ifdef CI_FCMPGT_N
  DEMO("fcmpgt", i, float, -1.5f, float, 2.5f, ci_fcmpgt(a, b), soft_less(b, a), CI_HARDWARE);
#else
  DEMO("fcmpgt", i, float, -1.5f, float, 2.5f, soft_less(b, a), soft_less(b, a), 0);
#endif
#ifdef CI_FCMPGE_N
  DEMO("fcmpge", i, float, -1.5f, float, 2.5f, ci_fcmpge(a, b), !soft_less(a, b), CI_HARDWARE);
#else
  DEMO("fcmpge", i, float, -1.5f, float, 2.5f, !soft_less(a, b), !soft_less(a, b), 0);
#endif
#ifdef CI_FCMPLE_N
  DEMO("fcmple", i, float, -1.5f, float, 2.5f, ci_fcmple(a, b), !soft_less(b, a), CI_HARDWARE);
#else
  DEMO("fcmple", i, float, -1.5f, float, 2.5f, !soft_less(b, a), !soft_less(b, a), 0);
#endif
#ifdef CI_FCMPEQ_N
  DEMO("fcmpeq", i, float, 2.5f, float, 2.5f, ci_fcmpeq(a, b), !soft_less(a, b) && !soft_less(b, a), CI_HARDWARE);
#else
  DEMO("fcmpeq", i, float, 2.5f, float, 2.5f, !soft_less(a, b) && !soft_less(b, a), !soft_less(a, b) && !soft_less(b, a), 0);
#endif
#ifdef CI_FCMPNE_N
  DEMO("fcmpne", i, float, 2.5f, float, 2.5f, ci_fcmpne(a, b), soft_less(a, b) || soft_less(b, a), CI_HARDWARE);
#else
  DEMO("fcmpne", i, float, 2.5f, float, 2.5f, soft_less(a, b) || soft_less(b, a), soft_less(a, b) || soft_less(b, a), 0);
#endif
#ifdef CI_FMIN_N
  DEMO("fmin", f, float, -1.5f, float, 2.5f, ci_fmin(a, b), (soft_less(b, a) ? b : a), CI_HARDWARE);
#else
  DEMO("fmin", f, float, -1.5f, float, 2.5f, (soft_less(b, a) ? b : a), (soft_less(b, a) ? b : a), 0);
#endif
#ifdef CI_FMAX_N
  DEMO("fmax", f, float, -1.5f, float, 2.5f, ci_fmax(a, b), (soft_less(a, b) ? b : a), CI_HARDWARE);
#else
  DEMO("fmax", f, float, -1.5f, float, 2.5f, (soft_less(a, b) ? b : a), (soft_less(a, b) ? b : a), 0);
#endif
#ifdef CI_FABS_N
  DEMO("fabs", f, float, -1.5f, float, 0.0f, ci_fabs(a), (soft_less(a, b) ? SOFT_SUB(b, a) : a), CI_HARDWARE);
#else
  DEMO("fabs", f, float, -1.5f, float, 0.0f, (soft_less(a, b) ? SOFT_SUB(b, a) : a), (soft_less(a, b) ? SOFT_SUB(b, a) : a), 0);
#endif
#ifdef CI_FNEG_N
  DEMO("fneg", f, float, -1.5f, float, 0.0f, ci_fneg(a), SOFT_SUB(b, a), CI_HARDWARE);
#else
  DEMO("fneg", f, float, -1.5f, float, 0.0f, SOFT_SUB(b, a), SOFT_SUB(b, a), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
