/* SPDX-License-Identifier: Apache-2.0 */
/* Deep call stacks: Ackermann, Hanoi, mutual recursion. */
#include "test.h"

static __attribute__((noinline)) uint32_t ackermann(uint32_t m, uint32_t n) {
  if (m == 0) return n + 1;
  return ackermann(m - 1, n == 0 ? 1 : ackermann(m, n - 1));
}

static uint32_t moves;
static void hanoi(int n, int from, int to) {
  if (n == 0) return;
  hanoi(n - 1, from, 3 - from - to);
  moves = moves * 3 + (uint32_t)(from * 4 + to);
  hanoi(n - 1, 3 - from - to, to);
}

static int is_odd(int n);
static __attribute__((noinline)) int is_even(int n) { return n == 0 ? 1 : is_odd(n - 1); }
static __attribute__((noinline)) int is_odd(int n) { return n == 0 ? 0 : is_even(n - 1); }

void test(void) {
  add(ackermann(2, 9));
  hanoi(8, 0, 2);
  add(moves);
  add((uint32_t)is_even(101));
}
