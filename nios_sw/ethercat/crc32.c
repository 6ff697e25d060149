/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-32, see crc32.h. Four bits at a time: a table of 64 bytes. */
#include "crc32.h"

#define REFLECTED 0xEDB88320u
#define STEP(crc) ((crc) >> 1 ^ ((crc) & 1u ? REFLECTED : 0u))
#define NIBBLE(n) STEP(STEP(STEP(STEP((uint32_t)(n)))))

static const uint32_t nibbles[16] = {
    NIBBLE(0), NIBBLE(1), NIBBLE(2),  NIBBLE(3),  NIBBLE(4),  NIBBLE(5),  NIBBLE(6),  NIBBLE(7),
    NIBBLE(8), NIBBLE(9), NIBBLE(10), NIBBLE(11), NIBBLE(12), NIBBLE(13), NIBBLE(14), NIBBLE(15),
};

uint32_t crc32(uint32_t crc, const void *data, uint32_t bytes) {
  const uint8_t *in = data;
  crc = ~crc;
  while (bytes--) {
    crc ^= *in++;
    crc = crc >> 4 ^ nibbles[crc & 15u];
    crc = crc >> 4 ^ nibbles[crc & 15u];
  }
  return ~crc;
}
