/* SPDX-License-Identifier: Apache-2.0 */
/* Flash of the reference system, which has none: memory of the processor, lost at power off and at reset. A product
 * replaces this file by the driver of its part, see flash.h. */
#include <string.h>

#include "flash.h"

const bool flash_lasts = false;

static uint8_t memory[FLASH_BYTES];
static bool used; /* what was never written is erased */

static void prepare(void) {
  if (!used) memset(memory, 0xFF, sizeof memory);
  used = true;
}

void flash_erase(uint32_t at) {
  prepare();
  memset(memory + at, 0xFF, FLASH_SECTOR);
}

void flash_write(uint32_t at, const void *from, uint32_t bytes) {
  const uint8_t *in = from;
  prepare();
  while (bytes--) memory[at++] &= *in++;
}

enum flash_state flash_state(void) { return FLASH_READY; }

void flash_read(uint32_t at, void *to, uint32_t bytes) {
  prepare();
  memcpy(to, memory + at, bytes);
}
