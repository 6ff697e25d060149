/* SPDX-License-Identifier: Apache-2.0 */
/* A double of the flash, see flash_double.h. A call that flash.h forbids ends the program. */
#include "flash_double.h"

#include <stdlib.h>
#include <string.h>

#include "flash.h"

#define NEVER 0xFFFFFFFFu

const bool flash_lasts = true;

static uint8_t content[FLASH_BYTES];
static uint32_t operations, fail_at = NEVER, cut_at = NEVER, polls, left;
static enum flash_state last;

void flash_double_clear(void) {
  memset(content, 0xFF, sizeof content);
  operations = polls = 0;
  flash_double_power_on();
}

void flash_double_power_on(void) {
  fail_at = cut_at = NEVER;
  left = 0;
  last = FLASH_READY;
}

void flash_double_slow(uint32_t count) { polls = count; }
void flash_double_fail_after(uint32_t count) { fail_at = operations + count; }
void flash_double_cut_after(uint32_t count) { cut_at = operations + count; }
uint32_t flash_double_operations(void) { return operations; }
uint8_t *flash_double_content(void) { return content; }

/* Bytes of the operation that are done. */
static uint32_t begin(uint32_t at, uint32_t bytes) {
  uint32_t number = operations++;
  if (left || at % 4 || bytes % 4 || at > FLASH_BYTES || bytes > FLASH_BYTES - at) abort();
  left = polls;
  last = number == fail_at ? FLASH_FAILED : FLASH_READY;
  if (number >= cut_at) left = NEVER;
  return number == fail_at || number > cut_at ? 0 : number == cut_at ? bytes / 2 : bytes;
}

void flash_erase(uint32_t at) {
  if (at % FLASH_SECTOR) abort();
  memset(content + at, 0xFF, begin(at, FLASH_SECTOR));
}

void flash_write(uint32_t at, const void *from, uint32_t bytes) {
  const uint8_t *in = from;
  for (uint32_t done = begin(at, bytes); done; --done) content[at++] &= *in++;
}

enum flash_state flash_state(void) {
  if (left && left != NEVER) --left;
  return left ? FLASH_BUSY : last;
}

void flash_read(uint32_t at, void *to, uint32_t bytes) {
  if (left || at > FLASH_BYTES || bytes > FLASH_BYTES - at) abort();
  memcpy(to, content + at, bytes);
}
