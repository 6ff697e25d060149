/* SPDX-License-Identifier: Apache-2.0 */
/* Custom instruction fsat: a limited to -b .. b, or to the bounds in an internal register.
 * Instruction: nios_sw/custom.toml; hardware: rtl/custom/ci_fsat.sv; test: tests/custom. */
#include "ci_demo.h"

static float limit(float a, float low, float high) {
  return soft_less(a, low) ? low : soft_less(high, a) ? high : a;
}

int main(void) {
  int failed = 0;
#ifdef CI_FSAT_SET_N
  ci_fsat_set(3, -1.0f, 4.0f); /* internal register 3: bounds of every ci_fsat_pair(x, 3) */
#endif
#ifdef CI_FSAT_N
  DEMO("fsat", f, float, -7.5f, float, 2.5f, ci_fsat(a, b), limit(a, -b, b), CI_HARDWARE);
#else
  DEMO("fsat", f, float, -7.5f, float, 2.5f, limit(a, -b, b), limit(a, -b, b), 0);
#endif
#ifdef CI_FSAT_PAIR_N
  DEMO("fsat_pair", f, float, 7.5f, float, 0.0f, ci_fsat_pair(a, 3), limit(a, -1.0f, 4.0f), CI_HARDWARE);
#else
  DEMO("fsat_pair", f, float, 7.5f, float, 0.0f, limit(a, -1.0f, 4.0f), limit(a, -1.0f, 4.0f), 0);
#endif
#ifdef CI_FSAT_LOW_N
  DEMO("fsat_low", f, float, 0.0f, float, 0.0f, ci_fsat_low(3), limit(-2.0f, -1.0f, 4.0f), CI_HARDWARE);
#else
  DEMO("fsat_low", f, float, 0.0f, float, 0.0f, limit(-2.0f, -1.0f, 4.0f), limit(-2.0f, -1.0f, 4.0f), 0);
#endif
#ifdef CI_FSAT_HIGH_N
  DEMO("fsat_high", f, float, 0.0f, float, 0.0f, ci_fsat_high(3), limit(5.0f, -1.0f, 4.0f), CI_HARDWARE);
#else
  DEMO("fsat_high", f, float, 0.0f, float, 0.0f, limit(5.0f, -1.0f, 4.0f), limit(5.0f, -1.0f, 4.0f), 0);
#endif
  program_exit((uint32_t)failed);
  return failed;
}
