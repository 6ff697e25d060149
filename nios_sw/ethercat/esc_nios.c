/* SPDX-License-Identifier: Apache-2.0 */
/* The slave controller at ESC_BASE of the Nios II system: its Avalon-MM port, whose byte enables follow the
 * width of an access. The widest accesses that alignment allows, from the lowest byte up. */
#include <string.h>

#include "esc.h"
#include "esc_nios.h"

/* Of ecat_application: the window, and the word that begins a fetch. */
#define WINDOW 0x4000u
#define FETCH 0x4200u
#define BYTES_LSB 16
_Static_assert(PROCESS_BYTES <= 512, "the window has 512 bytes");
#define WORDS 4 /* of a step: a load and what needs it are apart, and the loop costs less */

static volatile uint8_t *at(uint16_t address) { return esc_at(address); }

void esc_read(uint16_t address, void *to, uint16_t bytes) {
  uint8_t *out = to;
  while (bytes) {
    if (!(address & 3u) && bytes >= 4) {
      uint32_t word = (uint32_t)__builtin_ldwio(at(address));
      memcpy(out, &word, 4);
      address += 4, out += 4, bytes -= 4;
    } else if (!(address & 1u) && bytes >= 2) {
      uint16_t half = (uint16_t)__builtin_ldhuio(at(address));
      memcpy(out, &half, 2);
      address += 2, out += 2, bytes -= 2;
    } else {
      *out++ = (uint8_t)__builtin_ldbuio(at(address++));
      --bytes;
    }
  }
}

void esc_write(uint16_t address, const void *from, uint16_t bytes) {
  const uint8_t *in = from;
  if (!((address | (uintptr_t)from) & 3u)) { /* the process data */
    volatile uint32_t *to = esc_at(address);
    volatile uint32_t *end = to + (bytes >> 2), *steps = to + (bytes >> 4) * WORDS;
    const uint32_t *word = from;
    while (to != steps) {
      uint32_t a = word[0], b = word[1], c = word[2], d = word[3];
      __builtin_stwio(to, (int)a);
      __builtin_stwio(to + 1, (int)b);
      __builtin_stwio(to + 2, (int)c);
      __builtin_stwio(to + 3, (int)d);
      to += WORDS;
      word += WORDS;
    }
    while (to != end) __builtin_stwio(to++, (int)*word++);
    in = (const uint8_t *)word;
    address = (uint16_t)(address + (bytes & ~3u));
    bytes &= 3u;
  }
  while (bytes) {
    if (!(address & 3u) && bytes >= 4) {
      uint32_t word;
      memcpy(&word, in, 4);
      __builtin_stwio(at(address), (int)word);
      address += 4, in += 4, bytes -= 4;
    } else if (!(address & 1u) && bytes >= 2) {
      uint16_t half;
      memcpy(&half, in, 2);
      __builtin_sthio(at(address), half);
      address += 2, in += 2, bytes -= 2;
    } else {
      __builtin_stbio(at(address++), *in++);
      --bytes;
    }
  }
}

void esc_fetch(uint16_t address, uint32_t *to, uint16_t bytes) {
  volatile uint32_t *from = esc_at(WINDOW);
  volatile uint32_t *end = from + ((bytes + 3u) >> 2), *steps = from + ((bytes + 3u) >> 4) * WORDS;
  __builtin_stwio(esc_at(FETCH), (int)(address | (uint32_t)bytes << BYTES_LSB));
  while (from != steps) { /* a load waits until its word has come */
    uint32_t a = (uint32_t)__builtin_ldwio(from), b = (uint32_t)__builtin_ldwio(from + 1);
    uint32_t c = (uint32_t)__builtin_ldwio(from + 2), d = (uint32_t)__builtin_ldwio(from + 3);
    to[0] = a;
    to[1] = b;
    to[2] = c;
    to[3] = d;
    from += WORDS;
    to += WORDS;
  }
  while (from != end) *to++ = (uint32_t)__builtin_ldwio(from++);
}

void esc_load_image(void) {
  volatile uint32_t *image = (volatile uint32_t *)(ESC_BASE + SII_IMAGE);
  for (uint16_t i = 0; i < SII_BYTES; i += 4) {
    uint32_t word = 0xFFFFFFFFu;
    if (i < sii_bytes) memcpy(&word, sii_image + i, sii_bytes - i < 4 ? (size_t)(sii_bytes - i) : 4u);
    __builtin_stwio(image++, (int)word);
  }
  esc_write16(ESC_SII_CONTROL, SII_RELOAD);
}
