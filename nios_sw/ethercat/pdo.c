/* SPDX-License-Identifier: Apache-2.0 */
/* Process data, see pdo.h. */
#include "pdo.h"

#include <string.h>

#include "dictionary.h"

/* How a mapped object is copied. The pass goes through one kind after the other: a loop for each is three times as fast
 * as one that asks for the kind of every object. */
enum { COPY_WORD, COPY_HALF, COPY_BYTE, COPY_HALVES, COPY_BYTES, COPY_KINDS };

/* One mapped object, and its place in the image of the process data. */
struct copy {
  uint8_t *data;
  uint16_t at, bytes;
};

struct limit {
  const struct entry *entry;
  uint8_t *data;
};

struct exchange {
  struct copy copies[MAPS * MAP_ENTRIES]; /* in the order of their kinds */
  uint8_t end[COPY_KINDS];                /* of the copies of a kind */
  struct limit limits[MAPS * MAP_ENTRIES];
  uint8_t limit_count;
};

static struct exchange exchanges[2];

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
static int kind_of(const struct copy *copy) {
  uintptr_t odd = (uintptr_t)copy->data | copy->at;
  if (copy->bytes == 4 && !(odd & 3u)) return COPY_WORD;
  if (copy->bytes == 4 && !(odd & 1u)) return COPY_HALVES;
  if (copy->bytes == 2 && !(odd & 1u)) return COPY_HALF;
  return copy->bytes == 1 ? COPY_BYTE : COPY_BYTES;
}

/* The mapped objects of a direction in the order of the image; padding is what is read from zeros and nothing that is
 * written. Returns how many there are, -1 if the master would write one of them twice. */
static int mapped(int side, struct copy *found) {
  static uint8_t zeros[32]; /* a padding has 31 bytes at most */
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
      struct copy copy = {.data = zeros, .at = at, .bytes = (uint16_t)((entry & 0xFFu) / 8u)};
      at = (uint16_t)(at + copy.bytes);
      if (entry >> 16 == 0) {
        if (side == PDO_TX) found[count++] = copy;
        continue;
      }
      if (dictionary_locate((uint16_t)(entry >> 16), (uint8_t)(entry >> 8), &place)) continue;
      copy.data = place.data;
      for (int n = 0; side == PDO_RX && n < count; ++n) {
        if (found[n].data == copy.data) return -1;
      }
      found[count++] = copy;
      if (side == PDO_RX && place.entry->flags & ENTRY_LIMITS) {
        exchange->limits[exchange->limit_count++] = (struct limit){place.entry, place.data};
      }
    }
  }
  return count;
}

uint16_t pdo_prepare(int side) {
  static struct copy found[MAPS * MAP_ENTRIES];
  struct exchange *exchange = &exchanges[side];
  uint8_t next = 0;
  int count = mapped(side, found);
  for (int kind = 0; kind < COPY_KINDS; ++kind) {
    for (int n = 0; n < count; ++n) {
      if (kind_of(&found[n]) == kind) exchange->copies[next++] = found[n];
    }
    exchange->end[kind] = next;
  }
  if (count < 0) return PDO_INVALID;
  return (uint16_t)assigned_bytes(side, objects.assign[side].count, -1, 0);
}

static inline void move_word(void *to, const void *from) { *(uint32_t *)to = *(const uint32_t *)from; }
static inline void move_half(void *to, const void *from) { *(uint16_t *)to = *(const uint16_t *)from; }

void pdo_outputs(const uint8_t *from) {
  const struct exchange *exchange = &exchanges[PDO_RX];
  const struct copy *copy = exchange->copies, *end = copy + exchange->end[COPY_WORD];
  for (; copy < end; ++copy) move_word(copy->data, from + copy->at);
  end = exchange->copies + exchange->end[COPY_HALF];
  for (; copy < end; ++copy) move_half(copy->data, from + copy->at);
  end = exchange->copies + exchange->end[COPY_BYTE];
  for (; copy < end; ++copy) *copy->data = from[copy->at];
  end = exchange->copies + exchange->end[COPY_HALVES];
  for (; copy < end; ++copy) {
    move_half(copy->data, from + copy->at);
    move_half(copy->data + 2, from + copy->at + 2);
  }
  end = exchange->copies + exchange->end[COPY_BYTES];
  for (; copy < end; ++copy) {
    for (uint16_t k = 0; k < copy->bytes; ++k) copy->data[k] = from[copy->at + k];
  }
  for (int n = 0; n < exchange->limit_count; ++n) {
    dictionary_limit(exchange->limits[n].entry, exchange->limits[n].data);
  }
}

void pdo_inputs(uint8_t *to) {
  const struct exchange *exchange = &exchanges[PDO_TX];
  const struct copy *copy = exchange->copies, *end = copy + exchange->end[COPY_WORD];
  for (; copy < end; ++copy) move_word(to + copy->at, copy->data);
  end = exchange->copies + exchange->end[COPY_HALF];
  for (; copy < end; ++copy) move_half(to + copy->at, copy->data);
  end = exchange->copies + exchange->end[COPY_BYTE];
  for (; copy < end; ++copy) to[copy->at] = *copy->data;
  end = exchange->copies + exchange->end[COPY_HALVES];
  for (; copy < end; ++copy) {
    move_half(to + copy->at, copy->data);
    move_half(to + copy->at + 2, copy->data + 2);
  }
  end = exchange->copies + exchange->end[COPY_BYTES];
  for (; copy < end; ++copy) {
    for (uint16_t k = 0; k < copy->bytes; ++k) to[copy->at + k] = copy->data[k];
  }
}
