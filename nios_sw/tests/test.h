/* SPDX-License-Identifier: Apache-2.0 */
/* A test computes a digest of everything that it finds out. The same source runs on the host, whose
 * C library is the reference. Only results that C or IEEE 754 define go into the digest. */
#ifndef NIOS_TEST_H
#define NIOS_TEST_H

#include <stdint.h>

/* The test: what it adds to the digest is what is compared. */
void test(void);

/* Adds a word, 64 bits, bytes, a text, the bits of a float or double (one NaN for all). */
void add(uint32_t word);
void add64(uint64_t value);
void add_bytes(const void *data, uint32_t bytes);
void add_text(const char *text);
void add_float(float value);
void add_double(double value);

/* Numbers that both sides draw (xorshift). */
uint32_t draw(void);
uint32_t draw_below(uint32_t limit);

/* A value that the compiler does not know. */
#define OPAQUE(x)                        \
  __extension__({                        \
    __typeof__((x) + 0) opaque_ = (x);   \
    __asm__("" : "+r"(opaque_));         \
    opaque_;                             \
  })

#endif
