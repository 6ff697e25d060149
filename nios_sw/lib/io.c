/* SPDX-License-Identifier: Apache-2.0 */
/* I/O layer, see io.h. */
#include "io.h"

#define TIMER_IRQ 1u /* bit of interrupt 0 */

volatile uint32_t unexpected_exceptions, unexpected_address;
static void (*timer_handler)(void);

void console_text(const char *text) {
  while (*text) io_write(REG_CONSOLE, (uint8_t)*text++);
}

void console_decimal(uint32_t value) {
  char digits[11];
  char *at = digits + 10;
  *at = 0;
  do {
    *--at = (char)('0' + value % 10u);
    value /= 10u;
  } while (value != 0);
  console_text(at);
}

void console_hex(uint32_t value) {
  for (int shift = 28; shift >= 0; shift -= 4) {
    io_write(REG_CONSOLE, (uint8_t)"0123456789abcdef"[value >> shift & 15]);
  }
}

void program_exit(uint32_t status) {
  io_write(REG_EXIT, status);
  for (;;) {
  }
}

void timer_start(uint32_t cycles, void (*handler)(void)) {
  timer_handler = handler;
  io_write(REG_TIMER_PERIOD, cycles);
  io_write(REG_TIMER_STATUS, 0);
  io_write(REG_TIMER_CONTROL, TIMER_CONTROL_RUN | TIMER_CONTROL_IRQ_ENABLE);
  __builtin_wrctl(3, (int)(__builtin_rdctl(3) | TIMER_IRQ)); /* ienable */
  __builtin_wrctl(0, 1);                                    /* status: PIE */
}

void timer_stop(void) {
  io_write(REG_TIMER_CONTROL, 0);
  io_write(REG_TIMER_STATUS, 0);
}

/* From crt0.S: pending interrupts (0: another exception) and the address to return to. */
void exception_handler(uint32_t pending, uint32_t address);
void exception_handler(uint32_t pending, uint32_t address) {
  if (pending & TIMER_IRQ) {
    io_write(REG_TIMER_STATUS, 0);
    timer_handler();
  } else {
    ++unexpected_exceptions;
    unexpected_address = address;
  }
}
