/* SPDX-License-Identifier: Apache-2.0 */
/* Calls through pointers: a table of operations and a small interpreter. */
#include "test.h"

typedef uint32_t (*operation)(uint32_t, uint32_t);
static uint32_t plus(uint32_t a, uint32_t b) { return a + b; }
static uint32_t times(uint32_t a, uint32_t b) { return a * b; }
static uint32_t either(uint32_t a, uint32_t b) { return a ^ b; }
static uint32_t roll(uint32_t a, uint32_t b) { return a << (b & 31) | a >> (-b & 31); }
static operation table[] = {plus, times, either, roll};

void test(void) {
  uint32_t value = 1;
  for (int i = 0; i < 200; ++i) {
    uint32_t word = draw();
    value = table[word & 3](value, word >> 2);
    add(value);
  }
}
