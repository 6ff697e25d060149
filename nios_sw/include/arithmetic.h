/* SPDX-License-Identifier: Apache-2.0 */
/* Operations of the law beyond + - * /. With the own custom instructions of FPGA2 each is one
 * instruction of ci.h, otherwise the C library and the compiler do it: the same values except for the
 * last bit of the sine. + - * / themselves, and on FPGA2 the square root, the conversion and
 * comparisons, are custom instructions by compiler options (ci_flags.mk). */
#ifndef NIOS_ARITHMETIC_H
#define NIOS_ARITHMETIC_H

#include <math.h>
#include <stdint.h>

#if defined(CI_PLATFORM) && CI_PLATFORM == 2
#define OWN_INSTRUCTIONS 1
#include "gen/ci.h"
#endif

#define ALWAYS_INLINE static inline __attribute__((always_inline))

/* A copy of x that the compiler takes for a new value, at no cost. A formula of the copy is computed
 * even where the same formula of x was computed before: the law is evaluated as it is printed. Each
 * pair of constants (place, leg) makes copies of its own. SHARE_SUBEXPRESSIONS turns this off. */
#ifdef SHARE_SUBEXPRESSIONS
#define AGAIN(x, place, leg) ((void)(place), (x))
#else
#define AGAIN(x, place, leg)                                   \
  __extension__({                                              \
    float again_ = (x);                                        \
    __asm__("" : "+r"(again_) : "i"((place) * 8 + (leg)));     \
    again_;                                                    \
  })
#endif

/* sqrt(x), x >= 0. */
ALWAYS_INLINE float square_root(float x) {
#ifdef DOUBLE_LIBRARY
  return (float)sqrt((double)x);
#else
  return sqrtf(x);
#endif
}

/* sin(x), abs(x) <= 256 rad. */
ALWAYS_INLINE float sine(float x) {
#ifdef OWN_INSTRUCTIONS
  return ci_fsin(x);
#elif defined(DOUBLE_LIBRARY)
  return (float)sin((double)x);
#else
  return sinf(x);
#endif
}

/* x limited to -limit .. limit. */
ALWAYS_INLINE float saturate(float x, float limit) {
#ifdef OWN_INSTRUCTIONS
  return ci_fsat(x, limit);
#else
  return x < -limit ? -limit : x > limit ? limit : x;
#endif
}

/* -1, 0 or 1. */
ALWAYS_INLINE float signum(float x) {
#ifdef OWN_INSTRUCTIONS
  return ci_fsign(x);
#else
  return x > 0.0f ? 1.0f : x < 0.0f ? -1.0f : 0.0f;
#endif
}

/* A count as a float, rounded to nearest even. */
ALWAYS_INLINE float float_of_int(int32_t n) { return (float)n; }

#endif
