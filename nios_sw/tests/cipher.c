/* SPDX-License-Identifier: Apache-2.0 */
/* A block cipher (XTEA) there and back, and a linear congruence. */
#include "test.h"

static void encipher(uint32_t v[2], const uint32_t k[4]) {
  uint32_t sum = 0;
  for (int i = 0; i < 32; ++i) {
    v[0] += ((v[1] << 4 ^ v[1] >> 5) + v[1]) ^ (sum + k[sum & 3]);
    sum += 0x9E3779B9u;
    v[1] += ((v[0] << 4 ^ v[0] >> 5) + v[0]) ^ (sum + k[sum >> 11 & 3]);
  }
}

static void decipher(uint32_t v[2], const uint32_t k[4]) {
  uint32_t sum = 0x9E3779B9u * 32;
  for (int i = 0; i < 32; ++i) {
    v[1] -= ((v[0] << 4 ^ v[0] >> 5) + v[0]) ^ (sum + k[sum >> 11 & 3]);
    sum -= 0x9E3779B9u;
    v[0] -= ((v[1] << 4 ^ v[1] >> 5) + v[1]) ^ (sum + k[sum & 3]);
  }
}

void test(void) {
  uint32_t key[4] = {draw(), draw(), draw(), draw()};
  for (int i = 0; i < 8; ++i) {
    uint32_t plain[2] = {draw(), draw()}, v[2] = {plain[0], plain[1]};
    encipher(v, key);
    add(v[0]);
    add(v[1]);
    decipher(v, key);
    add(v[0] == plain[0] && v[1] == plain[1]);
  }
}
