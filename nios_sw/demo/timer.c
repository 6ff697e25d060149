/* SPDX-License-Identifier: Apache-2.0 */
/* The timer: an interrupt every 500 cycles while the program computes, then control ticks that the timer
 * starts by itself. Returns the number of things that went wrong. */
#include "io.h"

enum { PERIOD = 500, EVENTS = 20 };

static volatile uint32_t events, last, shortest = UINT32_MAX, longest;

static void on_event(void) {
  uint32_t now = cycle_now();
  if (events > 0) {
    uint32_t elapsed = now - last;
    if (elapsed < shortest) shortest = elapsed;
    if (elapsed > longest) longest = elapsed;
  }
  last = now;
  ++events;
}

/* A sum that interrupts must not disturb. */
static uint32_t work(uint32_t n) {
  uint32_t sum = 0;
  for (uint32_t i = 1; i <= n; ++i) sum += i * i ^ i;
  return sum;
}

static uint32_t traps, trap_address;

static void on_exception(uint32_t cause, uint32_t address) {
  traps += cause == 3;
  trap_address = address;
}

int main(void) {
  uint32_t wrong = 0;
  uint32_t undisturbed = work(100);

  timer_start(PERIOD, on_event);
  while (events < EVENTS) wrong += work(100) != undisturbed;
  timer_stop();
  console_text("interrupts every ");
  console_decimal(shortest);
  console_text(" to ");
  console_decimal(longest);
  console_text(" cycles\n");
  /* the handler's own latency varies by a few instructions, the period does not */
  wrong += shortest < PERIOD - 60 || longest > PERIOD + 60;

  /* a trap is none of the timer's, even while the timer waits while interrupts are disabled */
  exceptions_call(on_exception);
  uint32_t before_trap = events;
  timer_start(PERIOD, on_event);
  __builtin_wrctl(0, 0);
  while (!(io_read(REG_TIMER_STATUS) & TIMER_STATUS_EVENT)) {
  }
  uint32_t trap_at;
  __asm__ volatile("nextpc %0\n\ttrap 3" : "=r"(trap_at) : : "memory");
  wrong += traps != 1 || trap_address != trap_at;
  wrong += events != before_trap;
  timer_stop();

  uint32_t before = io_read(REG_TICK_COUNT);
  io_write(REG_TIMER_PERIOD, PERIOD);
  io_write(REG_TIMER_CONTROL, TIMER_CONTROL_RUN | TIMER_CONTROL_TICK);
  for (uint32_t tick = 1; tick <= 3; ++tick) {
    while (!(io_read(REG_TICK_STATUS) & TICK_STATUS_PENDING)) {
    }
    wrong += io_read(REG_TICK_COUNT) != before + tick;
    io_write(REG_TICK_DONE, 0);
    wrong += io_read(REG_TICK_CYCLES) == 0 || io_read(REG_TICK_CYCLES) > 100;
  }
  wrong += (io_read(REG_TICK_STATUS) & TICK_STATUS_OVERRUN) != 0;
  while (!(io_read(REG_TICK_STATUS) & TICK_STATUS_OVERRUN)) { /* nobody ends the ticks */
  }
  wrong += io_read(REG_TICK_WORST) == 0 || io_read(REG_TICK_WORST) > 100;
  io_write(REG_TIMER_CONTROL, 0);
  wrong += io_read(REG_TIMER_COUNT) != 0;
  return (int)wrong;
}
