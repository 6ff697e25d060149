/* SPDX-License-Identifier: Apache-2.0 */
/* setjmp and longjmp out of nested calls. */
#include <setjmp.h>

#include "test.h"

static jmp_buf back;

static __attribute__((noinline)) void deep(int level, int end) {
  volatile uint32_t filler[4] = {1, 2, 3, (uint32_t)level};
  if (level == end) longjmp(back, end + 1);
  if (level < 9) deep(level + 1, end);
  add(filler[3]);
}

void test(void) {
  for (volatile int end = 0; end < 6; ++end) {
    int result = setjmp(back);
    if (result == 0) deep(0, end);
    add((uint32_t)result);
  }
}
