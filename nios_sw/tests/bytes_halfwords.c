/* SPDX-License-Identifier: Apache-2.0 */
/* Loads and stores of bytes and half-words, signed and unsigned, at every offset. */
#include "test.h"

static union {
  uint8_t byte[64];
  int8_t signed_byte[64];
  uint16_t half[32];
  int16_t signed_half[32];
  uint32_t word[16];
} memory;

void test(void) {
  for (unsigned i = 0; i < 16; ++i) memory.word[i] = draw();
  for (unsigned i = 0; i < 64; ++i) {
    add(memory.byte[i]);
    add((uint32_t)memory.signed_byte[i]);
    memory.byte[63 - i] = (uint8_t)draw();
  }
  for (unsigned i = 0; i < 32; ++i) {
    add(memory.half[i]);
    add((uint32_t)memory.signed_half[i]);
    memory.half[31 - i] = (uint16_t)draw();
  }
  for (unsigned i = 0; i < 16; ++i) add(memory.word[i]);
}
