/* SPDX-License-Identifier: Apache-2.0 */
/* The slave controller (ESC) seen from the application: bytes by their address (gen/esc_regs.h). On the
 * Nios II system esc_nios.c, on a host a double (tests/ethercat/esc_double.c). The order of accesses
 * counts: an area of a sync manager is taken with its first byte and handed over with its last. */
#ifndef ETHERCAT_ESC_H
#define ETHERCAT_ESC_H

#include <stdint.h>

#include "gen/esc_regs.h"

void esc_read(uint16_t address, void *to, uint16_t bytes);
void esc_write(uint16_t address, const void *from, uint16_t bytes);

#ifdef __nios2__

/* As esc_read, in less time; the address is a multiple of 4, and whole words are written to `to`. There is one window for
 * it in the controller, so only the control pass fetches. */
void esc_fetch(uint16_t address, uint32_t *to, uint16_t bytes);

/* Registers are aligned to their size: one access. */

#define ESC_BASE 0x21000000u

static inline volatile void *esc_at(uint16_t address) { return (volatile void *)(ESC_BASE + address); }
static inline uint8_t esc_read8(uint16_t address) { return (uint8_t)__builtin_ldbuio(esc_at(address)); }
static inline uint16_t esc_read16(uint16_t address) { return (uint16_t)__builtin_ldhuio(esc_at(address)); }
static inline uint32_t esc_read32(uint16_t address) { return (uint32_t)__builtin_ldwio(esc_at(address)); }

#else

static inline void esc_fetch(uint16_t address, uint32_t *to, uint16_t bytes) { esc_read(address, to, bytes); }

static inline uint8_t esc_read8(uint16_t address) {
  uint8_t value;
  esc_read(address, &value, 1);
  return value;
}

static inline uint16_t esc_read16(uint16_t address) {
  uint16_t value;
  esc_read(address, &value, 2);
  return value;
}

static inline uint32_t esc_read32(uint16_t address) {
  uint32_t value;
  esc_read(address, &value, 4);
  return value;
}

#endif

static inline void esc_write8(uint16_t address, uint8_t value) { esc_write(address, &value, 1); }
static inline void esc_write16(uint16_t address, uint16_t value) { esc_write(address, &value, 2); }

#endif
