/* SPDX-License-Identifier: Apache-2.0 */
/* Sieve of Eratosthenes on bits, and perfect powers. */
#include "test.h"

enum { LIMIT = 2000 };

void test(void) {
  static uint32_t composite[LIMIT / 32 + 1];
  uint32_t count = 0;
  for (uint32_t i = 2; i < LIMIT; ++i) {
    if (composite[i / 32] >> i % 32 & 1) continue;
    ++count;
    add(i);
    for (uint32_t j = i * i; j < LIMIT; j += i) composite[j / 32] |= 1u << j % 32;
  }
  add(count);
}
