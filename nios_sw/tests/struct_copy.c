/* SPDX-License-Identifier: Apache-2.0 */
/* Structures by value as arguments and results, copies of odd sizes. */
#include "test.h"

struct small {
  int16_t a;
  int8_t b;
};
struct large {
  int32_t x[5];
  uint8_t tail[7];
  double d;
};

static __attribute__((noinline)) struct small turn(struct small s) {
  return (struct small){.a = (int16_t)(s.b * 3), .b = (int8_t)s.a};
}

static __attribute__((noinline)) struct large mix(struct large l, struct small s, int k) {
  for (int i = 0; i < 5; ++i) l.x[i] = (int32_t)((uint32_t)l.x[i] * 31u + (uint32_t)(s.a + k * i));
  l.tail[k] ^= (uint8_t)s.b;
  l.d = l.d / 3.0 + k;
  return l;
}

void test(void) {
  struct large l = {{1, 2, 3, 4, 5}, {9, 8, 7, 6, 5, 4, 3}, 1.5};
  struct small s = {.a = 1234, .b = -7};
  for (int i = 0; i < 12; ++i) {
    s = turn(s);
    l = mix(l, s, i % 7);
    for (int j = 0; j < 5; ++j) add((uint32_t)l.x[j]);
    add_bytes(l.tail, sizeof l.tail);
    add_double(l.d);
    add((uint32_t)s.a);
  }
}
