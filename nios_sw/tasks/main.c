/* SPDX-License-Identifier: Apache-2.0 */
/* Two tasks that compute with custom instructions while a tick of 10 kHz preempts them, and a third that
 * takes their results from queues and compares each with the one that an undisturbed run gave. Both
 * use the same bounds register of the saturation instruction, with other bounds.
 *
 * Uses what C programs use: constructors, atexit, malloc, printf of floats, setjmp (in the kernel).
 * The status is the number of wrong results, 253 at most; 254 if a task starved. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gen/ci.h"
#include "io.h"
#include "tasks.h"

#ifndef TICKS
#define TICKS 200
#endif
enum { HZ = 10000, STACK = 4096, STEPS = 300, BOUNDS = 3 };

static struct task producers[2], checker;
static struct queue results[2];
static uint32_t expected[2], checked[2], wrong;
static const char *said = "no constructor ran";

/* A recurrence whose value depends on every operation before it. */
static uint32_t work(uint32_t which) {
  float limit = which ? 0.75f : 1.25f, x = 0.3f + 0.1f * (float)which;
#ifndef NO_BOUNDS
  ci_fsat_set(BOUNDS, -limit, limit);
#endif
  for (int i = 0; i < STEPS; ++i) {
    float y = x * 1.7f + sqrtf(fabsf(x)) / (1.0f + x * x);
#ifndef NO_BOUNDS
    x = ci_fsat_pair(y - 1.1f, BOUNDS);
#else
    y -= 1.1f;
    x = y > limit ? limit : y < -limit ? -limit : y;
#endif
  }
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

static void produce(uint32_t which) {
  for (;;) queue_send(&results[which], work(which));
}
static void produce_0(void) { produce(0); }
static void produce_1(void) { produce(1); }

static void check(void) {
  for (;;) {
    for (uint32_t which = 0; which < 2; ++which) {
      wrong += queue_receive(&results[which]) != expected[which];
      ++checked[which];
    }
    if (checked[0] % 8 == 0) task_sleep(40); /* the queues fill, and the producers wait */
  }
}

__attribute__((constructor)) static void begin(void) { said = "a constructor ran"; }
static void end(void) { printf("atexit, ticks %lu\n", (unsigned long)kernel_ticks()); }

int main(void) {
  atexit(end);
  printf("%s\n", said);
  for (uint32_t which = 0; which < 2; ++which) expected[which] = work(which);
  void (*const bodies[])(void) = {produce_0, produce_1, check};
  struct task *const all[] = {&producers[0], &producers[1], &checker};
  for (int i = 0; i < 3; ++i) {
    void *stack = malloc(STACK);
    if (!stack) return 255;
    task_create(all[i], bodies[i], stack, STACK);
  }
  kernel_run(CLOCK_MHZ * 1000000 / HZ, TICKS);
  uint32_t results_seen = checked[0] + checked[1];
  float each = (float)results_seen / TICKS;
  printf("%lu results, %.2f a tick, %lu wrong; switches %lu, %lu, %lu\n",
         (unsigned long)results_seen, (double)each, (unsigned long)wrong,
         (unsigned long)producers[0].switches, (unsigned long)producers[1].switches,
         (unsigned long)checker.switches);
  if (checked[0] == 0 || checked[1] == 0 || producers[0].switches < TICKS / 4) return 254;
  return wrong > 253 ? 253 : (int)wrong;
}
