/* SPDX-License-Identifier: Apache-2.0 */
/* A double of the slave controller for tests on a host: memory with what registers and sync managers do
 * for both sides. No wires, no frames, no FMMU. */
#ifndef ESC_DOUBLE_H
#define ESC_DOUBLE_H

#include <stdbool.h>
#include <stdint.h>

#define DOUBLE_BYTES 0x3000

void double_reset(void);
/* The master's access to registers and memory; whether it counts in the working counter. */
bool double_read(uint16_t address, uint8_t *to, uint16_t bytes);
bool double_write(uint16_t address, const uint8_t *from, uint16_t bytes);
/* The same, after the application's next read of the AL event. */
void double_write_late(uint16_t address, const uint8_t *from, uint16_t bytes);
/* Time goes by: the watchdog of the process data, SYNC0. */
void double_time(uint32_t ns);
/* Whether SYNC0 pulses while it is on; not before its start time, for one. */
void double_sync0(bool pulses);
void double_sii(const uint8_t *image, uint32_t bytes);

#endif
