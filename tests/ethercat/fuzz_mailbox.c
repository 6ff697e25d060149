/* SPDX-License-Identifier: Apache-2.0 */
/* Random messages into the mailbox of the application, under the sanitizers: fuzz MESSAGES SEED. Half of
 * them are requests with a part changed, so that they get far. In BOOT they are of FoE, and the flash is slow, fails
 * and loses its power. Prints how many were answered. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "application.h"
#include "esc.h"
#include "esc_double.h"
#include "flash_double.h"

static uint64_t state;

static uint32_t below(uint32_t limit) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return (uint32_t)(state >> 32) % limit;
}

static void manager(uint16_t n, uint16_t start, uint16_t length, uint8_t control) {
  const uint8_t bytes[8] = {(uint8_t)start, (uint8_t)(start >> 8), (uint8_t)length, (uint8_t)(length >> 8),
                            control, 0, 1, 0};
  double_write((uint16_t)ESC_SM_START(n), bytes, 8);
}

static void ask(uint8_t wanted) {
  const uint8_t word[2] = {(uint8_t)(wanted | ESC_AL_CONTROL_ACKNOWLEDGE_MASK), 0};
  double_write(ESC_AL_CONTROL, word, 2);
  for (int i = 0; i < 4; ++i) application_background();
}

static void put32(uint8_t *to, uint32_t value) {
  for (int i = 0; i < 4; ++i) to[i] = (uint8_t)(value >> 8 * i);
}

/* A message of FoE into `bytes`; mostly the next one of a transfer. */
static void file_message(uint8_t *bytes) {
  static const char name[] = "firmware";
  static uint32_t packet;
  uint16_t data = (uint16_t)(below(3) ? 244 : below(245));
  uint8_t code = (uint8_t)(below(8) ? 3 + below(2) : below(8));
  uint32_t value = below(8) ? ++packet : below(4) ? packet : below(20);
  if (below(24) == 0) code = (uint8_t)(1 + below(2));
  if (code == 1 || code == 2) {
    value = below(8) ? FOE_PASSWORD : below(4);
    data = sizeof name - 1;
    memcpy(bytes + 12, name, data);
    if (below(8) == 0) bytes[12 + below(data)] ^= (uint8_t)below(256);
    packet = code == 1;
  } else if (packet == 1 && below(8)) { /* a header that is right */
    memcpy(bytes + 12, "MTFW", 4);
    put32(bytes + 16, objects.product);
    put32(bytes + 20, below(4) ? below(9000) : (uint32_t)data - 16u);
  }
  bytes[0] = (uint8_t)(6 + data);
  bytes[1] = 0;
  bytes[5] = 4;
  bytes[6] = code;
  put32(bytes + 8, value);
}

static void disturb_flash(void) {
  uint32_t kind = below(4);
  if (kind == 0) flash_double_slow(below(40));
  if (kind == 1) flash_double_fail_after(below(20));
  if (kind == 2) flash_double_cut_after(below(20));
  if (kind == 3) flash_double_slow(0);
}

/* Power off and on: the flash has what it has. */
static void restart(uint8_t wanted) {
  double_reset();
  flash_double_power_on();
  application_start();
  manager(0, 0x1000, 256, 0x26);
  manager(1, 0x1100, 256, 0x22);
  ask(wanted);
}

int main(int count, char **arguments) {
  static const uint16_t indices[] = {0x1000, 0x1008, 0x1018, 0x1C12, 0x1C13, 0x1600, 0x1A10, 0x2000,
                                     0x2020, 0x6040, 0x6060, 0x607D, 0x60C2, 0x8040, 0x8A00, 0x8FFF};
  static const uint8_t commands[] = {0x40, 0x50, 0x60, 0x70, 0x00, 0x10, 0x01, 0x21, 0x31, 0x23, 0x2B, 0x2F,
                                     0x33, 0x80, 0x22};
  struct feedback feedback = {0};
  struct command command;
  long messages = count == 3 ? atol(arguments[1]) : 0, answered = 0;
  state = count == 3 ? (uint64_t)atol(arguments[2]) * 2654435761u + 88172645463325252u : 1;
  flash_double_clear();
  restart(2);
  for (long i = 0; i < messages; ++i) {
    uint8_t bytes[256], answer[256];
    uint16_t length = (uint16_t)(below(8) ? 2 + 8 + below(below(4) ? 16 : 240) : below(300));
    for (int k = 0; k < 256; ++k) bytes[k] = (uint8_t)below(256);
    bytes[0] = (uint8_t)length;
    bytes[1] = (uint8_t)(length >> 8);
    bytes[5] = 0x03;
    if (below(16) == 0) bytes[5] = (uint8_t)below(256);
    bytes[7] = below(4) ? 0x20 : 0x80;
    if (below(2)) {
      uint16_t index = indices[below(sizeof indices / sizeof *indices)];
      bytes[8] = commands[below(sizeof commands)];
      bytes[9] = (uint8_t)index;
      bytes[10] = (uint8_t)(index >> 8);
      bytes[11] = (uint8_t)below(12);
      if (below(2)) bytes[12] = (uint8_t)below(250), bytes[13] = (uint8_t)below(2), bytes[14] = bytes[15] = 0;
      if (bytes[7] == 0x80) {
        bytes[8] = (uint8_t)(1 + below(6));
        bytes[12] = below(2) ? (uint8_t)below(6) : (uint8_t)index;
        bytes[13] = bytes[12] < 6 ? 0 : (uint8_t)(index >> 8);
      }
    }
    if (esc_read8(ESC_AL_STATUS) == 3 && below(16)) file_message(bytes);
    double_write(0x1000, bytes, 256);
    for (int k = 0; k < 3; ++k) application_background();
    if (below(64) == 0) application_cycle(&feedback, &command);
    if (below(64) == 0) {
      bytes[0] = (uint8_t)(ESC_SM_ACTIVATE_ENABLE_MASK | below(2) << ESC_SM_ACTIVATE_REPEAT_LSB);
      double_write((uint16_t)ESC_SM_ACTIVATE(1), bytes, 1);
    }
    if (below(8)) answered += double_read(0x1100, answer, 256);
    if (below(2000) == 0) {
      manager(2, 0x1200, (uint16_t)below(520), 0x64);
      manager(3, 0x1800, (uint16_t)below(520), 0x20);
      ask((uint8_t)below(16));
      double_write(0x1200, bytes, 256);
    }
    if (below(500) == 0) disturb_flash();
    if (below(3000) == 0) restart((uint8_t)(below(3) ? 3 : 2));
    if (below(4000) == 0) {
      manager(0, 0x1000, 256, 0x26);
      manager(1, 0x1100, 256, 0x22);
      ask(1);
      ask(2);
    }
  }
  printf("%ld\n", answered);
  return 0;
}
