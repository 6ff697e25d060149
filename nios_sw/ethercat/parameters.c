/* SPDX-License-Identifier: Apache-2.0 */
/* Stored parameters, see parameters.h. A sector has a header, which is written last, and records. */
#include "parameters.h"

#include <string.h>

#include "crc32.h"
#include "diagnosis.h"
#include "dictionary.h"
#include "flash.h"

#define MAGIC 0x5350544Du /* MTPS */
#define SAVE 0x65766173u  /* "save" */
#define LOAD 0x64616F6Cu  /* "load" */
#define PLACES 2u
#define NONE PLACES
#define PART 8u /* records that one pass of the background writes */
#define MOST ((FLASH_SECTOR - sizeof(struct header)) / sizeof(struct record))

struct header {
  uint32_t magic, number, records, sum; /* number: the higher one is newer; sum: of the records, number, their count */
};
struct record {
  uint16_t index;
  uint8_t subindex, bytes;
  uint32_t value;
};

static struct {
  uint32_t place, number;
} present;
static struct {
  enum { NOTHING, ERASE, RECORDS, HEADER, FORGET, END } step;
  bool begun, failed; /* begun: a state of the flash is that of our work */
  uint32_t place, sum;
  uint16_t object; /* the next one, as dictionary_at counts */
  uint8_t entry, forgotten;
  struct header header;
  struct record part[PART];
} work;

static uint32_t sum_of(uint32_t records_sum, const struct header *header) {
  return crc32(records_sum, &header->number, 8);
}

static bool is_whole(uint32_t place, const struct header *header) {
  uint32_t sum = 0;
  if (header->records > MOST) return false;
  for (uint32_t n = 0; n < header->records; ++n) {
    struct record record;
    flash_read(FLASH_STORE(place) + sizeof *header + n * sizeof record, &record, sizeof record);
    sum = crc32(sum, &record, sizeof record);
  }
  return sum_of(sum, header) == header->sum;
}

/* Whether the dictionary took it. */
static bool load(const struct record *record) {
  struct place place;
  return !dictionary_locate(record->index, record->subindex, &place) && place.entry->flags & ENTRY_SAVED &&
         !dictionary_put(&place, (const uint8_t *)&record->value, record->bytes, true);
}

void parameters_start(void) {
  struct header header;
  uint32_t records = 0;
  bool damaged = false;
  work.step = NOTHING;
  work.failed = false;
  present.place = NONE;
  present.number = 0;
  objects.save_all = flash_lasts;
  for (uint32_t place = 0; place < PLACES; ++place) {
    flash_read(FLASH_STORE(place), &header, sizeof header);
    if (header.magic != MAGIC) continue;
    if (!is_whole(place, &header)) {
      damaged = true;
    } else if (header.number >= present.number) {
      present.place = place;
      present.number = header.number;
      records = header.records;
    }
  }
  if (present.place == NONE) {
    objects.stored_state = damaged ? PARAMETERS_DAMAGED : PARAMETERS_NONE;
  } else {
    objects.stored_state = damaged ? PARAMETERS_FORMER : PARAMETERS_LOADED;
  }
  if (damaged) diagnosis_note(DIAGNOSIS_DAMAGED, 0, objects.stored_state);
  if (present.place == NONE) return;
  for (uint32_t n = 0; n < records; ++n) {
    struct record record;
    flash_read(FLASH_STORE(present.place) + sizeof header + n * sizeof record, &record, sizeof record);
    if (!load(&record)) {
      objects.stored_state = PARAMETERS_PARTLY;
      diagnosis_note(DIAGNOSIS_REFUSED, record.index, record.subindex);
    }
  }
}

uint32_t parameters_command(uint16_t index, uint32_t signature) {
  if (signature != (index == PARAMETERS_SAVE ? SAVE : LOAD)) return ABORT_NOT_STORED;
  if (index == PARAMETERS_SAVE && !flash_lasts) return ABORT_NOT_STORED;
  if (work.step != NOTHING) return ABORT_STATE;
  memset(&work, 0, sizeof work);
  work.place = present.place == 0;
  work.step = index == PARAMETERS_SAVE ? ERASE : FORGET;
  return 0;
}

enum parameters parameters_state(void) {
  if (work.step != NOTHING) return PARAMETERS_WORKING;
  return work.failed ? PARAMETERS_FAILED : PARAMETERS_IDLE;
}

/* The next records into `part`; how many. */
static uint32_t collect(void) {
  const struct object *object;
  uint16_t index;
  uint32_t found = 0;
  while (found < PART && (object = dictionary_at(work.object, &index)) != 0) {
    const struct entry *entry = &dictionary_entries[object->first + work.entry];
    struct place place;
    if (entry->flags & ENTRY_SAVED && !dictionary_locate(index, entry->subindex, &place)) {
      struct record *record = &work.part[found++];
      memset(record, 0, sizeof *record);
      record->index = index;
      record->subindex = entry->subindex;
      record->bytes = (uint8_t)entry->bytes;
      dictionary_get(&place, (uint8_t *)&record->value);
    }
    if (++work.entry == object->count) {
      work.entry = 0;
      ++work.object;
    }
  }
  return found;
}

static void end(bool well) {
  if (!well) diagnosis_note(DIAGNOSIS_NOT_STORED, 0, 0);
  work.failed = !well;
  work.step = NOTHING;
}

static void write_records(void) {
  uint32_t count = collect();
  uint32_t at = FLASH_STORE(work.place) + sizeof work.header + work.header.records * sizeof(struct record);
  if (work.header.records + count > MOST) {
    end(false);
  } else if (count) {
    work.sum = crc32(work.sum, work.part, count * sizeof(struct record));
    work.header.records += count;
    flash_write(at, work.part, count * sizeof(struct record));
  } else {
    work.header.magic = MAGIC;
    work.header.number = present.number + 1;
    work.header.sum = sum_of(work.sum, &work.header);
    flash_write(FLASH_STORE(work.place), &work.header, sizeof work.header);
    work.step = HEADER;
  }
}

void parameters_work(void) {
  enum flash_state state;
  if (work.step == NOTHING) return;
  state = flash_state();
  if (state == FLASH_BUSY) return;
  if (state == FLASH_FAILED && work.begun) {
    end(false);
    return;
  }
  work.begun = true;
  if (work.step == ERASE) {
    flash_erase(FLASH_STORE(work.place));
    work.step = RECORDS;
  } else if (work.step == RECORDS) {
    write_records();
  } else if (work.step == HEADER) { /* it is there: is the whole? */
    bool whole = is_whole(work.place, &work.header);
    if (whole) {
      present.place = work.place;
      present.number = work.header.number;
    }
    end(whole);
  } else if (work.step == FORGET) { /* the present ones last: no older ones come back */
    flash_erase(FLASH_STORE(work.forgotten ? !work.place : work.place));
    if (++work.forgotten == PLACES) work.step = END;
  } else {
    present.place = NONE;
    end(true);
  }
}
