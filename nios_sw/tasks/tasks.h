/* SPDX-License-Identifier: Apache-2.0 */
/* A small preemptive kernel: tasks of equal rank that take turns at each tick of the timer, queues of
 * words between them. It shows what the port of a real-time operating system needs (docs/own_c_program.md). */
#ifndef TASKS_H
#define TASKS_H

#include <stdbool.h>
#include <stdint.h>

/* What switch.S saves, in its order. */
struct context {
  uint32_t r[23]; /* r1..r23 */
  uint32_t fp, ra, ea, estatus;
#ifndef NO_BOUNDS
  float bounds[32][2]; /* of the saturation instruction */
#endif
};

struct task {
  struct context *context; /* on its stack while it does not run */
  uint32_t wakes;          /* tick at which it is ready again */
  uint32_t switches;       /* how often it was resumed */
};

#define QUEUE_WORDS 8u
struct queue {
  volatile uint32_t first, count;
  uint32_t words[QUEUE_WORDS];
};

/* Add a task that runs `body`, which never returns. bytes: of its stack, a multiple of 4. */
void task_create(struct task *task, void (*body)(void), void *stack, uint32_t bytes);

/* Let the tasks run, with a tick every `cycles` of the clock, up to a number of ticks; returns then. */
void kernel_run(uint32_t cycles, uint32_t ticks);

uint32_t kernel_ticks(void);     /* since kernel_run */
void task_yield(void);           /* let the next task run */
void task_sleep(uint32_t ticks); /* so many ticks at least */

/* Both wait while the queue is full, or empty. */
void queue_send(struct queue *queue, uint32_t word);
uint32_t queue_receive(struct queue *queue);

/* Critical sections: nothing preempts what is between. Takes the result of critical_begin. */
static inline uint32_t critical_begin(void) {
  uint32_t status = (uint32_t)__builtin_rdctl(0);
  __builtin_wrctl(0, 0); /* PIE, the only bit of the status register */
  return status;
}
static inline void critical_end(uint32_t status) { __builtin_wrctl(0, (int)status); }

#endif
