/* SPDX-License-Identifier: Apache-2.0 */
/* Access to the object dictionary by index and subindex. Functions that can fail return 0 or the abort
 * code of an SDO (CiA 301). */
#ifndef ETHERCAT_DICTIONARY_H
#define ETHERCAT_DICTIONARY_H

#include <stdbool.h>
#include <stdint.h>

#include "gen/objects.h"

#define ABORT_TOGGLE 0x05030000u
#define ABORT_COMMAND 0x05040001u
#define ABORT_MEMORY 0x05040005u
#define ABORT_ACCESS 0x06010000u
#define ABORT_READ_ONLY 0x06010002u
#define ABORT_COUNT_NOT_ZERO 0x06010003u
#define ABORT_NO_OBJECT 0x06020000u
#define ABORT_NOT_MAPPABLE 0x06040041u
#define ABORT_PDO_LENGTH 0x06040042u
#define ABORT_LENGTH 0x06070010u
#define ABORT_TOO_LONG 0x06070012u
#define ABORT_TOO_SHORT 0x06070013u
#define ABORT_NO_SUBINDEX 0x06090011u
#define ABORT_RANGE 0x06090030u
#define ABORT_MOST_BELOW_LEAST 0x06090036u
#define ABORT_HARDWARE 0x06060000u
#define ABORT_NOT_STORED 0x08000020u
#define ABORT_STATE 0x08000022u

#define ENTRY_WRITE 0x01u
#define ENTRY_PREOP 0x02u  /* written in PREOP only */
#define ENTRY_RX 0x04u     /* may be mapped */
#define ENTRY_TX 0x08u
#define ENTRY_LIMITS 0x10u /* least and greatest hold */
#define ENTRY_STORED 0x20u /* has a place in struct objects; otherwise it is constant */
#define ENTRY_SAVED 0x40u  /* a stored parameter (1010) */

#define TYPE_BOOL 0x01u
#define TYPE_I8 0x02u
#define TYPE_I16 0x03u
#define TYPE_I32 0x04u
#define TYPE_U8 0x05u
#define TYPE_U16 0x06u
#define TYPE_F32 0x08u
#define TYPE_STRING 0x09u
#define TYPE_OCTETS 0x0Au /* as many as the entry has, 0 at first; never written by the master */

#define KIND_VAR 7u
#define KIND_RECORD 9u

struct entry {
  const char *name;
  const char *text;               /* initial value of a string */
  const int8_t *values;           /* what may be written: their number, then they; or 0 */
  uint32_t initial, least, greatest; /* bits of the type, sign extended */
  uint16_t offset, bytes;         /* in struct objects or struct axis_objects */
  uint8_t subindex, type, flags;
};

struct object {
  const char *name;
  uint16_t index, first; /* first of its entries */
  uint8_t kind, count, last; /* number of entries, highest subindex */
};

/* Where an entry is: data is 0 for a constant. */
struct place {
  const struct object *object;
  const struct entry *entry;
  uint8_t *data;
  uint16_t index;
};

extern struct objects objects;
extern const struct entry dictionary_entries[];
extern const struct object dictionary_objects[];
extern const uint16_t dictionary_own_count, dictionary_axis_count;
extern const uint16_t dictionary_before_count; /* of the own ones, below those of the axes */
#define LISTS 6 /* kinds of lists of objects (ETG.1000.6): 0 has the lengths of the others */
extern const uint16_t dictionary_lists[LISTS];

void dictionary_reset(void);
/* The n-th object and its index, rising; 0 after the last. */
const struct object *dictionary_at(uint16_t n, uint16_t *index);
/* The object, or 0; *base: what its entries' offsets count from. */
const struct object *dictionary_find(uint16_t index, uint8_t **base);
uint32_t dictionary_locate(uint16_t index, uint8_t subindex, struct place *place);
/* Bytes of the present value, and the value. */
uint16_t dictionary_length(const struct place *place);
void dictionary_get(const struct place *place, uint8_t *to);
/* Checks and stores; preop: whether the device is in PREOP. */
uint32_t dictionary_put(const struct place *place, const uint8_t *from, uint32_t bytes, bool preop);
/* A value from elsewhere that is in the object already, held within the limits of its entry, which has some. */
void dictionary_limit(const struct entry *entry, uint8_t *data);
/* Whether any entry can be written. */
bool dictionary_writable(const struct object *object);
/* All entries of an object from subindex `first` (0 or 1) on, subindex 0 in two bytes. */
uint32_t dictionary_get_all(uint16_t index, uint8_t first, uint8_t *to, uint16_t room, uint16_t *bytes);
uint32_t dictionary_put_all(uint16_t index, uint8_t first, const uint8_t *from, uint32_t bytes, bool preop);

#endif
