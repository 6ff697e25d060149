/* SPDX-License-Identifier: Apache-2.0 */
/* Access to the object dictionary, see dictionary.h. */
#include "dictionary.h"

#include <string.h>

#include "application.h"
#include "axis.h"
#include "diagnosis.h"
#include "guard.h"
#include "parameters.h"
#include "pdo.h"

struct objects objects;

static void store(const struct entry *entry, uint8_t *base) {
  if (!(entry->flags & ENTRY_STORED)) return;
  if (entry->type == TYPE_STRING) {
    size_t length = strlen(entry->text);
    memset(base + entry->offset, 0, entry->bytes);
    memcpy(base + entry->offset, entry->text, length < entry->bytes ? length : entry->bytes);
  } else if (entry->type == TYPE_OCTETS) {
    memset(base + entry->offset, 0, entry->bytes);
  } else {
    memcpy(base + entry->offset, &entry->initial, entry->bytes);
  }
}

void dictionary_reset(void) {
  for (uint16_t n = 0; n < dictionary_own_count + dictionary_axis_count; ++n) {
    const struct object *object = &dictionary_objects[n];
    for (uint8_t i = 0; i < object->count; ++i) {
      const struct entry *entry = &dictionary_entries[object->first + i];
      if (n < dictionary_own_count) {
        store(entry, (uint8_t *)&objects);
        continue;
      }
      for (int axis = 0; axis < AXES; ++axis) store(entry, (uint8_t *)&objects.axis[axis]);
    }
  }
}

/* Objects of the device come before those of the axes and after them. */
const struct object *dictionary_at(uint16_t n, uint16_t *index) {
  const struct object *object = &dictionary_objects[n];
  uint16_t axis = 0, of_axes = (uint16_t)(n - dictionary_before_count);
  if (n >= dictionary_before_count && of_axes < AXES * dictionary_axis_count) {
    axis = of_axes / dictionary_axis_count;
    object = &dictionary_objects[dictionary_own_count + of_axes % dictionary_axis_count];
  } else if (n >= dictionary_before_count) {
    n = (uint16_t)(n - AXES * dictionary_axis_count);
    if (n >= dictionary_own_count) return 0;
    object = &dictionary_objects[n];
  }
  *index = (uint16_t)(object->index + AXIS_STEP * axis);
  return object;
}

const struct object *dictionary_find(uint16_t index, uint8_t **base) {
  uint16_t low = 0, high = dictionary_own_count;
  *base = (uint8_t *)&objects;
  if (index >= AXIS_FIRST && index < AXIS_FIRST + AXES * AXIS_STEP) {
    *base = (uint8_t *)&objects.axis[(index - AXIS_FIRST) / AXIS_STEP];
    index = (uint16_t)(AXIS_FIRST + (index - AXIS_FIRST) % AXIS_STEP);
    low = dictionary_own_count;
    high = (uint16_t)(low + dictionary_axis_count);
  }
  while (low < high) {
    uint16_t middle = (uint16_t)((low + high) / 2);
    if (dictionary_objects[middle].index == index) return &dictionary_objects[middle];
    if (dictionary_objects[middle].index < index) {
      low = (uint16_t)(middle + 1);
    } else {
      high = middle;
    }
  }
  return 0;
}

uint32_t dictionary_locate(uint16_t index, uint8_t subindex, struct place *place) {
  uint8_t *base;
  place->object = dictionary_find(index, &base);
  place->index = index;
  if (!place->object) return ABORT_NO_OBJECT;
  for (uint8_t i = 0; i < place->object->count; ++i) {
    const struct entry *entry = &dictionary_entries[place->object->first + i];
    if (entry->subindex != subindex) continue;
    place->entry = entry;
    place->data = entry->flags & ENTRY_STORED ? base + entry->offset : 0;
    return 0;
  }
  return ABORT_NO_SUBINDEX;
}

uint16_t dictionary_length(const struct place *place) {
  uint16_t length = 0;
  if (place->entry->type != TYPE_STRING || !place->data) return place->entry->bytes;
  while (length < place->entry->bytes && place->data[length]) ++length;
  return length;
}

void dictionary_get(const struct place *place, uint8_t *to) {
  const void *from = &place->entry->initial;
  int guard;
  if (place->entry->type == TYPE_STRING) { /* the control pass writes none */
    memcpy(to, place->data ? place->data : (const void *)place->entry->text, dictionary_length(place));
    return;
  }
  if (place->data) from = place->data;
  guard = guard_enter(); /* all bytes of one value */
  memcpy(to, from, place->entry->bytes);
  guard_leave(guard);
  if (place->index == DIAGNOSIS) diagnosis_read(place->entry->subindex);
}

static int32_t extended(const struct entry *entry, uint32_t bits) {
  if (entry->type == TYPE_I8) return (int8_t)bits;
  return entry->type == TYPE_I16 ? (int16_t)bits : (int32_t)bits;
}

/* -1: the value, given by its bits, is below the entry's limits, or no number; 1: above them. */
static int beyond(const struct entry *entry, uint32_t bits) {
  if (entry->type == TYPE_F32) {
    float number, least, greatest;
    memcpy(&number, &bits, 4);
    memcpy(&least, &entry->least, 4);
    memcpy(&greatest, &entry->greatest, 4);
    return number > greatest ? 1 : number >= least ? 0 : -1;
  }
  if (entry->type == TYPE_I8 || entry->type == TYPE_I16 || entry->type == TYPE_I32) {
    int32_t value = extended(entry, bits);
    return value > (int32_t)entry->greatest ? 1 : value >= (int32_t)entry->least ? 0 : -1;
  }
  return bits > entry->greatest ? 1 : bits >= entry->least ? 0 : -1;
}

/* Whether the entry's limits and values allow the value, given by its bits. */
static bool allowed(const struct entry *entry, uint32_t bits) {
  if (entry->values) {
    for (int8_t i = 1; i <= entry->values[0]; ++i) {
      if (extended(entry, bits) == entry->values[i]) return true;
    }
    return false;
  }
  return !(entry->flags & ENTRY_LIMITS) || beyond(entry, bits) == 0;
}

void dictionary_limit(const struct entry *entry, uint8_t *data) {
  uint32_t bits = 0;
  int side;
  memcpy(&bits, data, entry->bytes);
  side = beyond(entry, bits);
  if (side) memcpy(data, side > 0 ? &entry->greatest : &entry->least, entry->bytes);
}

uint32_t dictionary_put(const struct place *place, const uint8_t *from, uint32_t bytes, bool preop) {
  const struct entry *entry = place->entry;
  uint32_t bits = 0, abort;
  int guard;
  if (!(entry->flags & ENTRY_WRITE)) return ABORT_READ_ONLY;
  if (entry->flags & ENTRY_PREOP && !preop) return ABORT_STATE;
  if (entry->type == TYPE_STRING) {
    if (bytes > entry->bytes) return ABORT_TOO_LONG;
    memset(place->data, 0, entry->bytes);
    memcpy(place->data, from, bytes);
    return 0;
  }
  if (bytes != entry->bytes) return ABORT_LENGTH;
  memcpy(&bits, from, bytes);
  if (!allowed(entry, bits)) return ABORT_RANGE;
  if (place->index == PARAMETERS_SAVE || place->index == PARAMETERS_LOAD) {
    return parameters_command(place->index, bits);
  }
  if (place->index == DIAGNOSIS) return diagnosis_write(entry->subindex, bits);
  abort = pdo_check(place->index, entry->subindex, bits);
  if (!abort) abort = axis_check(place->index, entry->subindex, bits);
  if (abort) return abort;
  guard = guard_enter();
  memcpy(place->data, from, bytes);
  guard_leave(guard);
  application_written(place->index, entry->subindex);
  return 0;
}

uint32_t dictionary_get_all(uint16_t index, uint8_t first, uint8_t *to, uint16_t room, uint16_t *bytes) {
  struct place place;
  uint32_t abort = dictionary_locate(index, 0, &place);
  *bytes = 0;
  if (abort) return abort;
  if (first > 1 || place.object->kind == KIND_VAR) return ABORT_NO_SUBINDEX;
  for (uint8_t i = first; i < place.object->count; ++i) {
    dictionary_locate(index, dictionary_entries[place.object->first + i].subindex, &place);
    if (*bytes + dictionary_length(&place) + 1u > room) return ABORT_MEMORY;
    dictionary_get(&place, to + *bytes);
    *bytes = (uint16_t)(*bytes + dictionary_length(&place));
    if (i == 0) to[(*bytes)++] = 0;
  }
  return 0;
}

bool dictionary_writable(const struct object *object) {
  for (uint8_t i = 0; i < object->count; ++i) {
    if (dictionary_entries[object->first + i].flags & ENTRY_WRITE) return true;
  }
  return false;
}

/* A list of process data takes its entries while its count is 0 and is checked with the count: without subindex 0 the
 * access does not touch the count, so the list refuses it while it is in use. */
uint32_t dictionary_put_all(uint16_t index, uint8_t first, const uint8_t *from, uint32_t bytes, bool preop) {
  static const uint8_t none;
  struct place place, count;
  uint32_t abort = dictionary_locate(index, 0, &count), at = 0;
  bool counted;
  if (abort) return abort;
  if (first > 1 || count.object->kind == KIND_VAR) return ABORT_NO_SUBINDEX;
  if (!dictionary_writable(count.object)) return ABORT_READ_ONLY;
  counted = count.entry->flags & ENTRY_WRITE;
  if (first == 0) {
    if (bytes < 2) return ABORT_TOO_SHORT;
    at = 2;
  }
  if (counted && first == 0) {
    abort = dictionary_put(&count, &none, 1, preop);
    if (abort) return abort;
  }
  for (uint8_t i = 1; i < count.object->count && at < bytes; ++i) {
    dictionary_locate(index, dictionary_entries[count.object->first + i].subindex, &place);
    if (at + place.entry->bytes > bytes) return ABORT_LENGTH;
    if (place.entry->flags & ENTRY_WRITE) {
      abort = dictionary_put(&place, from + at, place.entry->bytes, preop);
      if (abort) return abort;
    }
    at += place.entry->bytes;
  }
  if (at != bytes) return ABORT_TOO_LONG;
  if (first == 0 && counted) return dictionary_put(&count, from, 1, preop);
  return 0;
}
