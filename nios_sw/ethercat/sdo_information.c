/* SPDX-License-Identifier: Apache-2.0 */
/* SDO information: lists of objects, descriptions of objects and entries (ETG.1000.6 5.6.3). */
#include <string.h>

#include "coe.h"
#include "dictionary.h"
#include "mailbox.h"

#define HEADER 4 /* opcode, reserved, fragments left */
#define ROOM (MAILBOX_DATA - COE_HEADER - HEADER)
#define LIST_REQUEST 1
#define OBJECT_REQUEST 3
#define ENTRY_REQUEST 5
#define ERROR_ANSWER 7
#define INCOMPLETE 0x80

#define TYPE_PDO_MAPPING 0x21u
#define TYPE_IDENTITY 0x23u

static uint8_t message[MAILBOX_DATA];
/* The list that is being sent: its kind, place of the next object, what of it is still to be sent. */
static uint16_t list, next, left;

void sdo_information_start(void) { left = 0; }

static void put16(uint8_t *to, uint32_t value) {
  to[0] = (uint8_t)value;
  to[1] = (uint8_t)(value >> 8);
}

static uint16_t get16(const uint8_t *from) { return (uint16_t)(from[0] | from[1] << 8); }

static bool send(uint8_t opcode, uint16_t fragments, uint16_t bytes) {
  put16(message, COE_SDO_INFORMATION << 12);
  message[COE_HEADER] = (uint8_t)(opcode | (fragments ? INCOMPLETE : 0));
  message[COE_HEADER + 1] = 0;
  put16(message + COE_HEADER + 2, fragments);
  return mailbox_send(MAILBOX_COE, message, (uint16_t)(COE_HEADER + HEADER + bytes));
}

static void refuse(uint32_t code) {
  uint8_t *data = message + COE_HEADER + HEADER;
  put16(data, code);
  put16(data + 2, code >> 16);
  send(ERROR_ANSWER, 0, 4);
}

/* Whether an object is of a list: 1 all, 2 to map as rx, 3 as tx, 4 to store for a replacement,
 * 5 settings. */
static bool listed(const struct object *object, uint16_t kind) {
  for (uint8_t i = 0; i < object->count; ++i) {
    uint8_t flags = dictionary_entries[object->first + i].flags;
    if (kind == 1 || (kind == 2 && flags & ENTRY_RX) || (kind == 3 && flags & ENTRY_TX)) return true;
    if (kind == 4 && flags & ENTRY_SAVED) return true;
    if (kind == 5 && flags & ENTRY_WRITE && !(flags & ENTRY_RX)) return true;
  }
  return false;
}

/* One message of the list: the first begins with its kind. */
static bool send_list(bool first) {
  uint8_t *data = message + COE_HEADER + HEADER;
  uint16_t bytes = 0, fragments = (uint16_t)((2u * left + ROOM - 1u) / ROOM), index, from = next;
  if (first) {
    fragments = (uint16_t)((2u * left + 2u + ROOM - 1u) / ROOM);
    put16(data, list);
    bytes = 2;
  }
  uint16_t count = 0;
  const struct object *object;
  while (bytes + 2 <= ROOM && count < left && (object = dictionary_at(from, &index)) != 0) {
    if (listed(object, list)) {
      put16(data + bytes, index);
      bytes = (uint16_t)(bytes + 2);
      ++count;
    }
    ++from;
  }
  if (!send(LIST_REQUEST + 1, (uint16_t)(fragments - 1), bytes)) return false;
  next = from;
  left = (uint16_t)(left - count);
  return true;
}

bool sdo_information_continue(void) { return left && (send_list(false), true); }

static uint16_t append_name(uint8_t *to, const char *name, uint16_t room) {
  uint16_t length = (uint16_t)strlen(name);
  if (length > room) length = room;
  memcpy(to, name, length);
  return length;
}

static void describe_object(uint16_t index) {
  uint8_t *base, *data = message + COE_HEADER + HEADER;
  const struct object *object = dictionary_find(index, &base);
  const struct entry *entry;
  uint16_t type;
  if (!object) {
    refuse(ABORT_NO_OBJECT);
    return;
  }
  entry = &dictionary_entries[object->first + (object->kind == KIND_VAR ? 0 : object->count - 1)];
  type = entry->type;
  if (object->kind == KIND_RECORD) {
    type = index == 0x1018u ? TYPE_IDENTITY : entry->flags & ENTRY_PREOP ? TYPE_PDO_MAPPING : 0;
  }
  put16(data, index);
  put16(data + 2, type);
  data[4] = object->last;
  data[5] = object->kind;
  send(OBJECT_REQUEST + 1, 0, (uint16_t)(6 + append_name(data + 6, object->name, ROOM - 6)));
}

static uint16_t access_of(const struct entry *entry) {
  uint16_t access = 0x07; /* read in PREOP, SAFEOP, OP */
  if (entry->flags & ENTRY_WRITE) access |= entry->flags & ENTRY_PREOP ? 0x08 : 0x38;
  if (entry->flags & ENTRY_RX) access |= 0x40;
  if (entry->flags & ENTRY_TX) access |= 0x80;
  if (entry->flags & ENTRY_SAVED) access |= 0x100;
  return access;
}

/* Answers with default (bit 4), least (5) and greatest value (6) if they are requested and known. */
static void describe_entry(uint16_t index, uint8_t subindex, uint8_t wanted) {
  struct place place;
  uint8_t *data = message + COE_HEADER + HEADER;
  uint32_t abort = dictionary_locate(index, subindex, &place);
  const struct entry *entry = place.entry;
  uint16_t bytes = 10;
  if (abort) {
    refuse(abort);
    return;
  }
  put16(data, index);
  data[2] = subindex;
  data[3] = 0;
  put16(data + 4, entry->type);
  put16(data + 6, entry->type == TYPE_BOOL ? 1u : 8u * entry->bytes);
  put16(data + 8, access_of(entry));
  if (entry->type != TYPE_STRING && entry->type != TYPE_OCTETS) {
    const uint32_t *values[3] = {&entry->initial, &entry->least, &entry->greatest};
    for (int i = 0; i < 3; ++i) {
      uint8_t bit = (uint8_t)(0x10 << i);
      if (!(wanted & bit) || (i && !(entry->flags & ENTRY_LIMITS))) continue;
      memcpy(data + bytes, values[i], entry->bytes);
      data[3] |= bit;
      bytes = (uint16_t)(bytes + entry->bytes);
    }
  }
  bytes = (uint16_t)(bytes + append_name(data + bytes, entry->name, (uint16_t)(ROOM - bytes)));
  send(ENTRY_REQUEST + 1, 0, bytes);
}

void sdo_information_request(const uint8_t *request, uint16_t bytes) {
  static const uint8_t needed[] = {[LIST_REQUEST] = 2, [OBJECT_REQUEST] = 2, [ENTRY_REQUEST] = 4};
  uint8_t opcode = bytes ? request[0] & 0x7Fu : 0;
  const uint8_t *data = request + HEADER;
  left = 0;
  if (opcode >= sizeof needed || !needed[opcode] || bytes < HEADER + needed[opcode]) {
    refuse(ABORT_COMMAND);
    return;
  }
  if (opcode == OBJECT_REQUEST) {
    describe_object(get16(data));
    return;
  }
  if (opcode == ENTRY_REQUEST) {
    describe_entry(get16(data), data[2], data[3]);
    return;
  }
  list = get16(data);
  if (list >= LISTS) {
    refuse(ABORT_ACCESS);
  } else if (list == 0) {
    put16(message + COE_HEADER + HEADER, 0);
    for (uint16_t kind = 1; kind < LISTS; ++kind) {
      put16(message + COE_HEADER + HEADER + 2u * kind, dictionary_lists[kind]);
    }
    send(LIST_REQUEST + 1, 0, 2 * LISTS);
  } else {
    next = 0;
    left = dictionary_lists[list];
    send_list(true);
  }
}
