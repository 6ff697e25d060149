/* SPDX-License-Identifier: Apache-2.0 */
/* The kernel of tasks.h. Its only assembly is switch.S. */
#include "tasks.h"

#include <setjmp.h>

#include "io.h"

enum { TASKS = 8, TRAP = 3, TIMER_IRQ = 1, IENABLE = 3, EXCEPTION = 7 };

static struct task *tasks[TASKS];
static uint32_t count, running;
static volatile uint32_t ticks;
static uint32_t last_tick;
static jmp_buf caller; /* of kernel_run */

struct context *kernel_switch(uint32_t pending, struct context *context);
void kernel_go(struct context *context) __attribute__((noreturn));

void task_create(struct task *task, void (*body)(void), void *stack, uint32_t bytes) {
  task->context = (struct context *)((uintptr_t)stack + bytes) - 1;
  *task->context = (struct context){.ea = (uint32_t)(uintptr_t)body, .estatus = 1}; /* PIE on */
  task->wakes = 0;
  task->switches = 0;
  if (count < TASKS) tasks[count++] = task;
}

/* Next task in turn whose time has come; the one that runs if there is no other. */
static struct task *next_ready(void) {
  for (;;) {
    for (uint32_t i = 1; i <= count; ++i) {
      uint32_t n = (running + i) % count;
      if ((int32_t)(ticks - tasks[n]->wakes) >= 0) {
        running = n;
        return tasks[n];
      }
    }
    while (!(io_read(REG_TIMER_STATUS) & TIMER_STATUS_EVENT)) { /* idle: all sleep */
    }
    io_write(REG_TIMER_STATUS, 0);
    ++ticks;
  }
}

static void leave(void) { longjmp(caller, 1); }

/* From switch.S, at a timer interrupt or at the trap of task_yield, on the stack of the task. */
struct context *kernel_switch(uint32_t pending, struct context *context) {
  tasks[running]->context = context;
  if (pending & TIMER_IRQ) {
    io_write(REG_TIMER_STATUS, 0);
    ++ticks;
  } else if (((uint32_t)__builtin_rdctl(EXCEPTION) >> 2 & 31u) != TRAP) {
    console_text("exception of a task\n");
    program_exit(EXIT_EXCEPTION);
  }
  if ((int32_t)(ticks - last_tick) >= 0) { /* go on in kernel_run, interrupts off */
    timer_stop();
    context->ea = (uint32_t)(uintptr_t)leave;
    context->estatus = 0;
    return context;
  }
  struct task *next = next_ready();
  ++next->switches;
  return next->context;
}

void kernel_run(uint32_t cycles, uint32_t until) {
  if (setjmp(caller)) return;
  ticks = 0;
  last_tick = until;
  running = 0;
  io_write(REG_TIMER_PERIOD, cycles);
  io_write(REG_TIMER_STATUS, 0);
  io_write(REG_TIMER_CONTROL, TIMER_CONTROL_RUN | TIMER_CONTROL_IRQ_ENABLE);
  __builtin_wrctl(IENABLE, TIMER_IRQ);
  kernel_go(tasks[0]->context);
}

uint32_t kernel_ticks(void) { return ticks; }

void task_yield(void) { __asm__ volatile("trap 0" ::: "memory"); }

void task_sleep(uint32_t wait) {
  tasks[running]->wakes = ticks + wait;
  task_yield();
}

void queue_send(struct queue *queue, uint32_t word) {
  uint32_t status = critical_begin();
  while (queue->count == QUEUE_WORDS) {
    critical_end(status);
    task_yield();
    status = critical_begin();
  }
  queue->words[(queue->first + queue->count) % QUEUE_WORDS] = word;
  queue->count++;
  critical_end(status);
}

uint32_t queue_receive(struct queue *queue) {
  uint32_t status = critical_begin();
  while (queue->count == 0) {
    critical_end(status);
    task_yield();
    status = critical_begin();
  }
  uint32_t word = queue->words[queue->first];
  queue->first = (queue->first + 1) % QUEUE_WORDS;
  queue->count--;
  critical_end(status);
  return word;
}
