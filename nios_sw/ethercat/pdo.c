/* SPDX-License-Identifier: Apache-2.0 */
/* Process data, see pdo.h. */
#include "pdo.h"

#include <string.h>

#include "dictionary.h"

/* How a mapped object is copied. The pass goes through one kind after the other: a loop for each is three times as fast
 * as one that asks for the kind of every object. A word at an odd half of the image is two halves. */
enum { COPY_WORD, COPY_HALF, COPY_BYTE, COPY_BYTES, COPY_KINDS };
#define STEP 4 /* copies at once: loads and the stores that need them are apart, and the loop costs less */

/* One mapped object, or a half of one, and its place in the image. */
struct copy {
  uint8_t *data, *image;
};

struct limit {
  const struct entry *entry;
  uint8_t *data;
};

struct exchange {
  struct copy copies[2 * MAPS * MAP_ENTRIES]; /* in the order of their kinds */
  uint8_t count[COPY_KINDS];
  uint8_t bytes[MAPS * MAP_ENTRIES]; /* of the last kind */
  struct limit limits[MAPS * MAP_ENTRIES];
  uint8_t limit_count;
};

/* What is to be copied, in the order of the image. */
struct found {
  uint8_t *data;
  uint16_t at, bytes;
};

static struct exchange exchanges[2];
union pdo_image pdo_image[2];

static uint16_t map_bytes(int side, int map, uint32_t count) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < count; ++i) bits += objects.map[side][map].entry[i] & 0xFFu;
  return (uint16_t)(bits / 8u);
}

/* Bytes of a direction if the list had `count` elements and the map `other` (-1: none) so many bytes. */
static uint32_t assigned_bytes(int side, uint32_t count, int other, uint32_t other_bytes) {
  uint32_t bytes = 0;
  uint16_t first = side == PDO_RX ? RX_MAP : TX_MAP;
  for (uint32_t i = 0; i < count; ++i) {
    uint16_t pdo = objects.assign[side].pdo[i];
    int map = (pdo - first) >> 4;
    if (pdo) bytes += map == other ? other_bytes : map_bytes(side, map, objects.map[side][map].count);
  }
  return bytes;
}

static uint32_t check_assign(int side, uint8_t subindex, uint32_t value) {
  uint16_t first = side == PDO_RX ? RX_MAP : TX_MAP;
  if (subindex == 0) {
    if (value > MAPS) return ABORT_RANGE;
    for (uint32_t i = 0; i < value; ++i) {
      for (uint32_t k = 0; k < i; ++k) {
        if (objects.assign[side].pdo[i] == objects.assign[side].pdo[k]) return ABORT_NOT_MAPPABLE;
      }
    }
    return assigned_bytes(side, value, -1, 0) > PROCESS_BYTES ? ABORT_PDO_LENGTH : 0;
  }
  if (objects.assign[side].count) return ABORT_COUNT_NOT_ZERO;
  if (value == 0) return 0;
  if (value < first || value > first + 0x10u * (MAPS - 1) || (value - first) & 0xFu) {
    return ABORT_NOT_MAPPABLE;
  }
  return 0;
}

static uint32_t check_map(int side, int map, uint8_t subindex, uint32_t value) {
  struct place place;
  uint8_t bits = (uint8_t)value, kind = side == PDO_RX ? ENTRY_RX : ENTRY_TX;
  uint32_t abort, bytes;
  if (subindex == 0) {
    if (value > MAP_ENTRIES) return ABORT_RANGE;
    for (uint32_t i = 0; i < value; ++i) {
      if (!objects.map[side][map].entry[i]) return ABORT_NOT_MAPPABLE;
    }
    /* The list may have this map already. */
    bytes = assigned_bytes(side, objects.assign[side].count, map, map_bytes(side, map, value));
    return bytes > PROCESS_BYTES ? ABORT_PDO_LENGTH : 0;
  }
  if (objects.map[side][map].count) return ABORT_COUNT_NOT_ZERO;
  if (value == 0) return 0;
  if (bits & 7u || !bits) return ABORT_NOT_MAPPABLE;
  if (value >> 16 == 0) return value & 0xFF00u ? ABORT_NOT_MAPPABLE : 0; /* padding */
  abort = dictionary_locate((uint16_t)(value >> 16), (uint8_t)(value >> 8), &place);
  if (abort) return abort;
  if (!(place.entry->flags & kind) || place.entry->bytes * 8u != bits) return ABORT_NOT_MAPPABLE;
  return 0;
}

uint32_t pdo_check(uint16_t index, uint8_t subindex, uint32_t value) {
  if (index == 0x1C12u || index == 0x1C13u) return check_assign(index - 0x1C12, subindex, value);
  for (int side = PDO_RX; side <= PDO_TX; ++side) {
    uint16_t first = side == PDO_RX ? RX_MAP : TX_MAP;
    if (index >= first && index < first + 0x10u * MAPS) {
      return check_map(side, (index - first) >> 4, subindex, value);
    }
  }
  return 0;
}

/* Objects are aligned to their size, their places in the image need not be; the image is aligned to a word. */
static int kind_of(const struct found *found) {
  uintptr_t odd = (uintptr_t)found->data | found->at;
  if (found->bytes == 4 && !(odd & 3u)) return COPY_WORD;
  if ((found->bytes == 2 || found->bytes == 4) && !(odd & 1u)) return COPY_HALF;
  return found->bytes == 1 ? COPY_BYTE : COPY_BYTES;
}

/* The mapped objects of a direction in the order of the image, without padding. Returns how many there are, -1 if the
 * master would write one of them twice. */
static int mapped(int side, struct found *found) {
  struct exchange *exchange = &exchanges[side];
  uint16_t first = side == PDO_RX ? RX_MAP : TX_MAP, at = 0;
  struct place place;
  int count = 0;
  exchange->limit_count = 0;
  for (uint8_t i = 0; i < objects.assign[side].count; ++i) {
    uint16_t pdo = objects.assign[side].pdo[i];
    int map = (pdo - first) >> 4;
    if (!pdo) continue;
    for (uint8_t k = 0; k < objects.map[side][map].count; ++k) {
      uint32_t entry = objects.map[side][map].entry[k];
      struct found one = {.at = at, .bytes = (uint16_t)((entry & 0xFFu) / 8u)};
      at = (uint16_t)(at + one.bytes);
      if (entry >> 16 == 0) continue;
      if (dictionary_locate((uint16_t)(entry >> 16), (uint8_t)(entry >> 8), &place)) continue;
      one.data = place.data;
      for (int n = 0; side == PDO_RX && n < count; ++n) {
        if (found[n].data == one.data) return -1;
      }
      found[count++] = one;
      if (side == PDO_RX && place.entry->flags & ENTRY_LIMITS) {
        exchange->limits[exchange->limit_count++] = (struct limit){place.entry, place.data};
      }
    }
  }
  return count;
}

uint16_t pdo_prepare(int side) {
  static struct found found[MAPS * MAP_ENTRIES];
  struct exchange *exchange = &exchanges[side];
  struct copy *next = exchange->copies, *first;
  int count = mapped(side, found);
  memset(pdo_image[side].bytes, 0, PROCESS_BYTES); /* padding stays 0 */
  for (int kind = 0; kind < COPY_KINDS; ++kind) {
    first = next;
    for (int n = 0; n < count; ++n) {
      uint8_t *image = pdo_image[side].bytes + found[n].at;
      if (kind_of(&found[n]) != kind) continue;
      if (kind == COPY_BYTES) exchange->bytes[next - first] = (uint8_t)found[n].bytes;
      *next++ = (struct copy){found[n].data, image};
      if (kind == COPY_HALF && found[n].bytes == 4) *next++ = (struct copy){found[n].data + 2, image + 2};
    }
    exchange->count[kind] = (uint8_t)(next - first);
  }
  if (count < 0) return PDO_INVALID;
  return (uint16_t)assigned_bytes(side, objects.assign[side].count, -1, 0);
}

#define ALWAYS_INLINE static inline __attribute__((always_inline))

ALWAYS_INLINE uint32_t get(const void *from, int kind) {
  if (kind == COPY_WORD) return *(const uint32_t *)from;
  return kind == COPY_HALF ? *(const uint16_t *)from : *(const uint8_t *)from;
}

ALWAYS_INLINE void put(void *to, int kind, uint32_t value) {
  if (kind == COPY_WORD) {
    *(uint32_t *)to = value;
  } else if (kind == COPY_HALF) {
    *(uint16_t *)to = (uint16_t)value;
  } else {
    *(uint8_t *)to = (uint8_t)value;
  }
}

/* The copies of a kind, from the image or to it; what is after them. No place is read that another copy writes. */
ALWAYS_INLINE const struct copy *copy_all(const struct copy *copy, uint32_t count, int kind, int side) {
  const struct copy *steps = copy + count / STEP * STEP, *end = copy + count;
  for (; copy != steps; copy += STEP) {
    uint8_t *to[STEP], *from[STEP];
    uint32_t value[STEP];
    for (int n = 0; n < STEP; ++n) {
      to[n] = side == PDO_RX ? copy[n].data : copy[n].image;
      from[n] = side == PDO_RX ? copy[n].image : copy[n].data;
    }
    for (int n = 0; n < STEP; ++n) value[n] = get(from[n], kind);
    for (int n = 0; n < STEP; ++n) put(to[n], kind, value[n]);
  }
  for (; copy != end; ++copy) {
    put(side == PDO_RX ? copy->data : copy->image, kind, get(side == PDO_RX ? copy->image : copy->data, kind));
  }
  return copy;
}

ALWAYS_INLINE void exchange_all(int side) {
  const struct exchange *exchange = &exchanges[side];
  const struct copy *copy = exchange->copies;
  copy = copy_all(copy, exchange->count[COPY_WORD], COPY_WORD, side);
  copy = copy_all(copy, exchange->count[COPY_HALF], COPY_HALF, side);
  copy = copy_all(copy, exchange->count[COPY_BYTE], COPY_BYTE, side);
  for (int n = 0; n < exchange->count[COPY_BYTES]; ++n, ++copy) {
    for (int k = 0; k < exchange->bytes[n]; ++k) {
      if (side == PDO_RX) copy->data[k] = copy->image[k];
      if (side == PDO_TX) copy->image[k] = copy->data[k];
    }
  }
}

void pdo_outputs(void) {
  const struct exchange *exchange = &exchanges[PDO_RX];
  exchange_all(PDO_RX);
  for (int n = 0; n < exchange->limit_count; ++n) {
    dictionary_limit(exchange->limits[n].entry, exchange->limits[n].data);
  }
}

void pdo_inputs(void) { exchange_all(PDO_TX); }
