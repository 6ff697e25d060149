# SPDX-License-Identifier: Apache-2.0
"""Operations of the core as text of C: expressions, and functions where C has none that agrees."""

TESTS = frozenset({"feq", "flt", "fle"})
FUSED = {
    "fmadd": ("fmaf({0}, {1}, {2})", "{0} * {1} + {2}"),
    "fnmsub": ("fmaf(-{0}, {1}, {2})", "{2} - {0} * {1}"),
    "fmsub": ("fmaf({0}, {1}, -{2})", "{0} * {1} - {2}"),
    "fnmadd": ("fmaf(-{0}, {1}, -{2})", "-({0} * {1}) - {2}"),
}
"""Multiply-adds with one rounding, and with two."""
FORMS = {
    "fmul": "{0} * {1}",
    "fnmul": "-({0} * {1})",
    "fadd": "{0} + {1}",
    "fsub": "{0} - {1}",
    "fdiv": "{0} / {1}",
    "fneg": "-{0}",
    "fabs": "fabsf({0})",
    "fsqrt": "sqrtf({0})",
    "feq": "(float)({0} == {1})",
    "flt": "(float)({0} < {1})",
    "fle": "(float)({0} <= {1})",
    "i2f": "(float){0}",
    "sel": "{0} < 0.0f || {0} > 0.0f ? {1} : {2}",
    "selge": "{0} >= 0.0f ? {1} : {2}",
    "selgt": "{0} > 0.0f ? {1} : {2}",
}
"""Operations that are expressions of C; the others are functions of `HELPERS`."""
HELPERS = {
    "fmin": """\
/* The smaller; a number rather than a NaN, -0 rather than +0. */
static inline float fmin_(float a, float b) {
#ifdef OWN_INSTRUCTIONS
  return ci_fmin(a, b);
#else
  return b != b || a < b || (a == b && signbit(a)) ? a : b;
#endif
}
""",
    "fmax": """\
/* The larger; a number rather than a NaN, +0 rather than -0. */
static inline float fmax_(float a, float b) {
#ifdef OWN_INSTRUCTIONS
  return ci_fmax(a, b);
#else
  return b != b || a > b || (a == b && signbit(b)) ? a : b;
#endif
}
""",
    "fsat": """\
/* a limited to low .. high. */
static inline float fsat_(float a, float low, float high) {
#ifdef OWN_INSTRUCTIONS
  if (__builtin_constant_p(low == -high) && low == -high) return ci_fsat(a, high);
#endif
  return a < low ? low : a > high ? high : a;
}
""",
    "fsgn": """\
/* -1, 0 or 1; of a NaN NaN. */
static inline float fsgn_(float a) {
#ifdef OWN_INSTRUCTIONS
  return ci_fsign(a);
#else
  return a > 0.0f ? 1.0f : a < 0.0f ? -1.0f : a == 0.0f ? 0.0f : a;
#endif
}
""",
    "fsin": """\
/* Sine of a in radians; NaN beyond 256. */
static inline float fsin_(float a) {
#ifdef OWN_INSTRUCTIONS
  return ci_fsin(a);
#else
  return fabsf(a) <= 256.0f ? sinf(a) : NAN;
#endif
}
""",
    "fcos": """\
/* Cosine of a in radians; NaN beyond 256. */
static inline float fcos_(float a) {
#ifdef OWN_INSTRUCTIONS
  return ci_fcos(a);
#else
  return fabsf(a) <= 256.0f ? cosf(a) : NAN;
#endif
}
""",
    "f2i": """\
/* To nearest even; beyond int32 and of a NaN the nearest end of its range, 2^31 - 1. */
static inline int32_t f2i_(float a) {
  a = rintf(a);
  return a < 2147483648.0f ? a >= -2147483648.0f ? (int32_t)a : INT32_MIN : INT32_MAX;
}
""",
    "f2it": """\
/* Toward zero; beyond int32 and of a NaN the nearest end of its range, 2^31 - 1. */
static inline int32_t f2it_(float a) {
  return a < 2147483648.0f ? a >= -2147483648.0f ? (int32_t)a : INT32_MIN : INT32_MAX;
}
""",
    "iadd": """\
/* Modulo 2^32. */
static inline int32_t iadd_(int32_t a, int32_t b) {
  return (int32_t)((uint32_t)a + (uint32_t)b);
}
""",
    "isub": """\
/* Modulo 2^32. */
static inline int32_t isub_(int32_t a, int32_t b) {
  return (int32_t)((uint32_t)a - (uint32_t)b);
}
""",
    "bits": """\
/* The bits of a float as an integer. */
static inline int32_t bits_(float a) {
  int32_t word;
  memcpy(&word, &a, sizeof word);
  return word;
}
""",
    "power": """\
/* 2^n of the number 1.5*2^23 + n. */
static inline float power_(float b) {
  uint32_t word;
  float a;
  memcpy(&word, &b, sizeof word);
  word = ((word + 127u) & 255u) << 23;
  memcpy(&a, &word, sizeof a);
  return a;
}
""",
    "above": """\
/* The larger of a and 0; of a NaN NaN. */
static inline float above_(float a) {
  return a <= 0.0f ? 0.0f : a;
}
""",
    "number": """\
/* The float of these bits. */
static inline float number_(int32_t word) {
  float a;
  memcpy(&a, &word, sizeof a);
  return a;
}
""",
}
PRELUDE = """\
/* GCC contracts products whose sums and differences alternate in spite of the first option. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off", "no-tree-slp-vectorize")
#else
#pragma STDC FP_CONTRACT OFF
#endif
#include <float.h>
#include <math.h>
#include <string.h>

#if defined(__FAST_MATH__) || FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 1 || FLT_EVAL_METHOD == 2
#error "compile without -ffast-math, with single precision kept single (x87: -mfpmath=sse)"
#endif
#if defined(CI_PLATFORM) && CI_PLATFORM == 2 && defined(__nios2__)
#define OWN_INSTRUCTIONS 1
#include "gen/ci.h"
#endif
"""
C_WORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while linux unix i386 errno signbit NAN INFINITY NULL asm class "
    "delete new this private public protected template virtual friend operator export namespace "
    "using throw try catch bool true false explicit mutable typename wchar_t".split()
)
