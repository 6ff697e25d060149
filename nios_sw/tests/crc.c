/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-32 bitwise and by table, Adler-32. */
#include "test.h"

static uint32_t table[256];

void test(void) {
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xEDB88320u ^ c >> 1 : c >> 1;
    table[i] = c;
  }
  uint32_t crc = 0xFFFFFFFFu, slow = 0xFFFFFFFFu, s1 = 1, s2 = 0;
  for (int i = 0; i < 300; ++i) {
    uint8_t byte = (uint8_t)draw();
    crc = table[(crc ^ byte) & 0xFF] ^ crc >> 8;
    slow ^= byte;
    for (int k = 0; k < 8; ++k) slow = slow >> 1 ^ (0xEDB88320u & -(slow & 1));
    s1 = (s1 + byte) % 65521u;
    s2 = (s2 + s1) % 65521u;
  }
  add(~crc);
  add(crc == slow);
  add(s2 << 16 | s1);
}
