/* SPDX-License-Identifier: Apache-2.0 */
/* I/O layer: registers of system.h, console, interrupts, exceptions. Needs no C library. */
#ifndef NIOS_IO_H
#define NIOS_IO_H

#include <stdint.h>

#include "gen/system.h"

static inline uint32_t io_read(uint32_t address) {
  return (uint32_t)__builtin_ldwio((const volatile void *)address);
}

static inline void io_write(uint32_t address, uint32_t word) {
  __builtin_stwio((volatile void *)address, (int)word);
}

/* Clock cycles since reset. */
static inline uint32_t cycle_now(void) { return io_read(REG_CYCLE); }

/* Text and numbers to the console. */
void console_text(const char *text);
void console_decimal(uint32_t value);
void console_hex(uint32_t value);

/* Ends the program: status to the host; does not return. */
void program_exit(uint32_t status) __attribute__((noreturn));

/* Timer: an event every `cycles`; each event calls `handler` from the exception code. */
void timer_start(uint32_t cycles, void (*handler)(void));
void timer_stop(void);

/* Calls `handler` at every exception that is no interrupt, with its cause (docs/nios_core.md) and the
 * address of the instruction; the program goes on after it. Without a handler (0) an exception is
 * printed on the console and ends the program with the status EXIT_EXCEPTION + cause. */
#define EXIT_EXCEPTION 128u
void exceptions_call(void (*handler)(uint32_t cause, uint32_t address));

#endif
