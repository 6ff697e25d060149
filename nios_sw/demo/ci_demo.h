/* SPDX-License-Identifier: Apache-2.0 */
/* Demos of the custom instructions: runs an operation as instruction and in software, and prints
 *   fmul: hardware, 5 cycles (software: 61), same result
 * Cycles are those of the CPU per operation with the moves that the compiler puts around it. Where the platform has no such instruction, and on a host, only software runs. */
#ifndef CI_DEMO_H
#define CI_DEMO_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "gen/ci.h"

#ifdef __nios2__
#include "io.h"
/* The compiler's own routines, whatever instructions it may use elsewhere. */
float __addsf3(float, float);
float __subsf3(float, float);
float __mulsf3(float, float);
float __divsf3(float, float);
float __floatsisf(int);
int __fixsfsi(float);
int __ltsf2(float, float);
#define SOFT_ADD __addsf3
#define SOFT_SUB __subsf3
#define SOFT_MUL __mulsf3
#define SOFT_DIV __divsf3
#define SOFT_FLOAT __floatsisf
#define SOFT_FIX __fixsfsi
static inline int soft_less(float a, float b) { return __ltsf2(a, b) < 0; }
#else
#include <stdio.h>
#include <stdlib.h>
static inline void console_text(const char *text) { fputs(text, stdout); }
static inline void console_decimal(uint32_t value) { printf("%u", (unsigned)value); }
static inline void program_exit(uint32_t status) { exit((int)status); }
static inline uint32_t cycle_now(void) { return 0; }
static inline float soft_add(float a, float b) { return a + b; }
static inline float soft_sub(float a, float b) { return a - b; }
static inline float soft_mul(float a, float b) { return a * b; }
static inline float soft_div(float a, float b) { return a / b; }
static inline float soft_float(int a) { return (float)a; }
static inline int soft_fix(float a) { return (int)a; }
#define SOFT_ADD soft_add
#define SOFT_SUB soft_sub
#define SOFT_MUL soft_mul
#define SOFT_DIV soft_div
#define SOFT_FLOAT soft_float
#define SOFT_FIX soft_fix
static inline int soft_less(float a, float b) { return a < b; }
#endif

static inline uint32_t demo_word_f(float x) {
  uint32_t word;
  memcpy(&word, &x, sizeof word);
  return word;
}
static inline uint32_t demo_word_i(int x) { return (uint32_t)x; }

/* Cycles of `expression`, a function of a and b of this scope; its value goes to y. Nine in a row
 * less one, so that reading the counter cancels; the empty assembly keeps each in its place. */
#define DEMO_ONCE(y, expression)             \
  do {                                       \
    __asm__ volatile("" : "+r"(a), "+r"(b)); \
    y = (expression);                        \
    __asm__ volatile("" : "+r"(y));          \
  } while (0)
#define DEMO_MEASURE(cycles, y, expression)                          \
  do {                                                               \
    uint32_t begin_ = cycle_now(), middle_;                          \
    DEMO_ONCE(y, expression);                                        \
    middle_ = cycle_now();                                           \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    DEMO_ONCE(y, expression);                                        \
    cycles = (cycle_now() - middle_ - (middle_ - begin_) + 4u) / 8u; \
  } while (0)

/* The same in a function of its own, with registers of its own. */
#define DEMO_FUNCTION(type_a, type_b, y, expression)                                        \
  __extension__({                                                                           \
    __attribute__((noinline)) uint32_t measure_(type_a a, type_b b, __typeof__(y) *value) { \
      uint32_t cycles_;                                                                     \
      __typeof__(y) y_;                                                                     \
      DEMO_MEASURE(cycles_, y_, expression);                                                \
      *value = y_;                                                                          \
      return cycles_;                                                                       \
    }                                                                                       \
    measure_(a, b, &y);                                                                     \
  })

/* Prints the line of one operation; returns 1 where hardware and software differ. */
static inline int demo_report(const char *name, int hardware, uint32_t cycles, uint32_t software,
                              int same) {
  console_text(name);
  if (hardware) {
    console_text(": hardware, ");
    console_decimal(cycles);
    console_text(" cycles (software: ");
    console_decimal(software);
    console_text(same ? "), same result\n" : "), other result\n");
    return !same;
  }
#ifdef __nios2__
  console_text(": software, ");
  console_decimal(software);
  console_text(" cycles; no instruction on this platform\n");
#else
  console_text(same ? ": software on a host, same result\n" : ": software on a host, differs\n");
#endif
  return !same;
}

/* One operation: instruction(a, b) next to software(a, b); kind is f or i, the type of the result.
 * Values come through volatile, so that nothing is computed at compile time. */
#define DEMO(name, kind, type_a, value_a, type_b, value_b, instruction, software, hardware)        \
  do {                                                                                            \
    volatile type_a given_a = value_a;                                                            \
    volatile type_b given_b = value_b;                                                            \
    type_a a = given_a;                                                                           \
    type_b b = given_b;                                                                           \
    __typeof__(software) y, z;                                                                    \
    uint32_t hard_ = DEMO_FUNCTION(type_a, type_b, y, instruction);                               \
    uint32_t soft_ = DEMO_FUNCTION(type_a, type_b, z, software);                                  \
    failed |= demo_report(name, hardware, hard_, soft_,                                             \
                          demo_word_##kind(y) == demo_word_##kind(z));                            \
  } while (0)

#endif
