/* SPDX-License-Identifier: Apache-2.0 */
/* Runs a test. On Nios II its digest is the program's status, on the host it is printed. */
#include "test.h"

#include <string.h>

#ifndef __nios2__
#include <stdio.h>
#endif

static uint32_t digest = 2166136261u;
static uint32_t drawn = 2463534242u;

void add_bytes(const void *data, uint32_t bytes) {
  const uint8_t *at = data;
  while (bytes-- != 0) digest = (digest ^ *at++) * 16777619u; /* FNV-1a */
}

/* Byte by byte, so that the digest does not depend on byte order. */
void add(uint32_t word) {
  uint8_t bytes[4] = {(uint8_t)word, (uint8_t)(word >> 8), (uint8_t)(word >> 16),
                      (uint8_t)(word >> 24)};
  add_bytes(bytes, 4);
}

void add64(uint64_t value) {
  add((uint32_t)value);
  add((uint32_t)(value >> 32));
}

void add_text(const char *text) { add_bytes(text, (uint32_t)strlen(text) + 1); }

void add_float(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  add(value != value ? 0x7FC00000u : bits);
}

void add_double(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  add64(value != value ? 0x7FF8000000000000u : bits);
}

uint32_t draw(void) {
  drawn ^= drawn << 13;
  drawn ^= drawn >> 17;
  drawn ^= drawn << 5;
  return drawn;
}

uint32_t draw_below(uint32_t limit) { return draw() % limit; }

int main(void) {
  test();
#ifndef __nios2__
  printf("%08x\n", (unsigned)digest);
  return 0;
#else
  return (int)digest;
#endif
}
