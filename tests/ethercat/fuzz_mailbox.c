/* SPDX-License-Identifier: Apache-2.0 */
/* Random messages into the mailbox of the application, under the sanitizers: fuzz MESSAGES SEED. Half of
 * them are requests with a part changed, so that they get far. Prints how many were answered. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "application.h"
#include "esc.h"
#include "esc_double.h"

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

int main(int count, char **arguments) {
  static const uint16_t indices[] = {0x1000, 0x1008, 0x1018, 0x1C12, 0x1C13, 0x1600, 0x1A10, 0x2000,
                                     0x2020, 0x6040, 0x6060, 0x607D, 0x60C2, 0x8040, 0x8A00, 0x8FFF};
  static const uint8_t commands[] = {0x40, 0x50, 0x60, 0x70, 0x00, 0x10, 0x01, 0x21, 0x31, 0x23, 0x2B, 0x2F,
                                     0x33, 0x80, 0x22};
  struct feedback feedback = {0};
  struct command command;
  long messages = count == 3 ? atol(arguments[1]) : 0, answered = 0;
  state = count == 3 ? (uint64_t)atol(arguments[2]) * 2654435761u + 88172645463325252u : 1;
  double_reset();
  application_start();
  manager(0, 0x1000, 256, 0x26);
  manager(1, 0x1100, 256, 0x22);
  ask(2);
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
