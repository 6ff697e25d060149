/* SPDX-License-Identifier: Apache-2.0 */
/* Process data, see pdo.h. */
#include "pdo.h"

#include <string.h>

#include "dictionary.h"

/* One mapped object; data 0 is padding. */
struct copy {
  uint8_t *data;
  const struct entry *limits; /* 0: none */
  uint8_t bytes;
};

static struct copy copies[2][MAPS * MAP_ENTRIES];
static uint16_t copy_count[2];

static uint16_t map_bytes(int side, int map) {
  uint32_t bits = 0;
  for (uint8_t i = 0; i < objects.map[side][map].count; ++i) {
    bits += objects.map[side][map].entry[i] & 0xFFu;
  }
  return (uint16_t)(bits / 8u);
}

/* Bytes of a direction if the list had `count` elements and one map other contents. */
static uint32_t assigned_bytes(int side, uint32_t count) {
  uint32_t bytes = 0;
  uint16_t first = side == PDO_RX ? RX_MAP : TX_MAP;
  for (uint32_t i = 0; i < count; ++i) {
    uint16_t pdo = objects.assign[side].pdo[i];
    if (pdo) bytes += map_bytes(side, (pdo - first) >> 4);
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
    return assigned_bytes(side, value) > PROCESS_BYTES ? ABORT_PDO_LENGTH : 0;
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
  uint32_t abort;
  if (subindex == 0) {
    if (value > MAP_ENTRIES) return ABORT_RANGE;
    for (uint32_t i = 0; i < value; ++i) {
      if (!objects.map[side][map].entry[i]) return ABORT_NOT_MAPPABLE;
    }
    return 0;
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

uint16_t pdo_prepare(int side) {
  uint32_t bytes = assigned_bytes(side, objects.assign[side].count);
  uint16_t first = side == PDO_RX ? RX_MAP : TX_MAP, count = 0;
  struct place place;
  copy_count[side] = 0;
  if (bytes > PROCESS_BYTES) return (uint16_t)bytes; /* maps grew behind the list's back: refused there */
  for (uint8_t i = 0; i < objects.assign[side].count; ++i) {
    uint16_t pdo = objects.assign[side].pdo[i];
    int map = (pdo - first) >> 4;
    if (!pdo) continue;
    for (uint8_t k = 0; k < objects.map[side][map].count; ++k) {
      uint32_t entry = objects.map[side][map].entry[k];
      struct copy *copy = &copies[side][count++];
      copy->bytes = (uint8_t)(entry & 0xFFu) / 8u;
      copy->data = 0;
      copy->limits = 0;
      if (entry >> 16 && !dictionary_locate((uint16_t)(entry >> 16), (uint8_t)(entry >> 8), &place)) {
        copy->data = place.data;
        if (place.entry->flags & ENTRY_LIMITS) copy->limits = place.entry;
      }
    }
  }
  copy_count[side] = count;
  return (uint16_t)bytes;
}

/* Objects are aligned to their size, the image of the process data need not be. */
static void move(uint8_t *to, const uint8_t *from, uint8_t bytes) {
  uintptr_t odd = (uintptr_t)to | (uintptr_t)from;
  if (bytes == 4 && !(odd & 3u)) {
    *(uint32_t *)(void *)to = *(const uint32_t *)(const void *)from;
  } else if (!(bytes & 1u) && !(odd & 1u)) {
    for (uint8_t k = 0; k < bytes; k = (uint8_t)(k + 2)) {
      *(uint16_t *)(void *)(to + k) = *(const uint16_t *)(const void *)(from + k);
    }
  } else {
    for (uint8_t k = 0; k < bytes; ++k) to[k] = from[k];
  }
}

void pdo_outputs(const uint8_t *from) {
  const struct copy *end = copies[PDO_RX] + copy_count[PDO_RX];
  for (const struct copy *copy = copies[PDO_RX]; copy < end; ++copy) {
    if (copy->data) move(copy->data, from, copy->bytes);
    if (copy->limits) dictionary_limit(copy->limits, copy->data);
    from += copy->bytes;
  }
}

void pdo_inputs(uint8_t *to) {
  const struct copy *end = copies[PDO_TX] + copy_count[PDO_TX];
  for (const struct copy *copy = copies[PDO_TX]; copy < end; ++copy) {
    if (copy->data) {
      move(to, copy->data, copy->bytes);
    } else {
      for (uint8_t k = 0; k < copy->bytes; ++k) to[k] = 0;
    }
    to += copy->bytes;
  }
}
