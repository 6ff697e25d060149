/* SPDX-License-Identifier: Apache-2.0 */
/* I/O layer, see io.h. */
#include "io.h"

#define TIMER_IRQ 1u /* bit of interrupt 0 */

static void (*timer_handler)(void);
static void (*exception_call)(uint32_t cause, uint32_t address);

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

void exceptions_call(void (*handler)(uint32_t cause, uint32_t address)) {
  exception_call = handler;
}

static void unhandled(uint32_t cause, uint32_t address) __attribute__((noreturn));
static void unhandled(uint32_t cause, uint32_t address) {
  static const char *const names[] = {[2] = "interrupt without a handler",
                                      [3] = "trap",
                                      [4] = "unimplemented instruction",
                                      [5] = "illegal instruction",
                                      [6] = "misaligned data address",
                                      [7] = "jump to a misaligned address or out of the code",
                                      [8] = "division"};
  const char *name = cause < sizeof names / sizeof *names ? names[cause] : 0;
  console_text("\nunhandled exception ");
  console_decimal(cause);
  console_text(name ? ", " : "");
  console_text(name ? name : "");
  console_text(", at 0x");
  console_hex(address);
  if (cause == 6 || cause == 7) {
    console_text(", address 0x");
    console_hex((uint32_t)__builtin_rdctl(12)); /* badaddr */
  }
  console_text("\n");
  program_exit(EXIT_EXCEPTION + cause);
}

/* From crt0.S: pending interrupts (0: another exception) and the address to return to. */
void exception_handler(uint32_t pending, uint32_t address);
void exception_handler(uint32_t pending, uint32_t address) {
  uint32_t cause = ((uint32_t)__builtin_rdctl(7) >> 2) & 31u; /* exception */
  if (pending & TIMER_IRQ && timer_handler) {
    io_write(REG_TIMER_STATUS, 0);
    timer_handler();
  } else if (!pending && exception_call) {
    exception_call(cause, address - 4u);
  } else {
    unhandled(cause, pending ? address : address - 4u);
  }
}
