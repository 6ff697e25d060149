/* SPDX-License-Identifier: Apache-2.0 */
/* Firmware images, see image.h. */
#include "image.h"

#include <string.h>

#include "crc32.h"
#include "dictionary.h"
#include "flash.h"
#include "foe.h"
#include "parameters.h"

#define PART 256u /* bytes that one pass of the background checks */
#define FILE_MAGIC 0x5746544Du /* MTFW */
#define RECORD_MAGIC 0x474D494Du /* MIMG */
#define NONE 2u

struct record {
  uint32_t magic, number, sum, unused; /* number: the higher one is the newer image; sum: of magic and number */
};
struct header {
  uint32_t magic, product, bytes, sum;
};

static struct {
  uint32_t place; /* 0, 1, NONE */
  uint32_t number, bytes;
} present;
static struct {
  enum { STORE, CHECK, RECORD } step;
  bool begun, last; /* begun: a state of the flash is that of our work */
  uint16_t result;  /* IMAGE_WORKING or what image_work returns */
  uint32_t place, erased, received, checked; /* bytes */
  uint32_t sum;     /* of the content so far: as it came, then as the flash has it */
  struct header header;
  struct record record;
  _Alignas(4) uint8_t chunk[IMAGE_CHUNK];
  uint16_t bytes; /* in chunk */
} next;

static uint32_t record_sum(const struct record *record) { return crc32(0, record, 8); }

/* Check sum of the content from `from` to `to` in a place, continued. */
static uint32_t sum_of(uint32_t sum, uint32_t place, uint32_t from, uint32_t to) {
  static uint8_t part[PART];
  while (from < to) {
    uint32_t bytes = to - from < PART ? to - from : PART;
    flash_read(FLASH_IMAGE(place) + sizeof(struct record) + sizeof(struct header) + from, part, bytes);
    sum = crc32(sum, part, bytes);
    from += bytes;
  }
  return sum;
}

static bool fits(uint32_t content) {
  return content <= FLASH_IMAGE_BYTES - sizeof(struct record) - sizeof(struct header);
}

void image_start(void) {
  present.place = NONE;
  present.number = 0;
  next.result = 0;
  next.bytes = 0;
  for (uint32_t place = 0; place < NONE; ++place) {
    struct record record;
    struct header header;
    flash_read(FLASH_IMAGE(place), &record, sizeof record);
    flash_read(FLASH_IMAGE(place) + sizeof record, &header, sizeof header);
    if (record.magic != RECORD_MAGIC || record.sum != record_sum(&record) || record.number < present.number) continue;
    if (header.magic != FILE_MAGIC || !fits(header.bytes)) continue;
    if (sum_of(0, place, 0, header.bytes) != header.sum) continue;
    present.place = place;
    present.number = record.number;
    present.bytes = header.bytes + sizeof header;
  }
}

bool image_current(uint32_t *at, uint32_t *bytes) {
  if (present.place == NONE) return false;
  *at = FLASH_IMAGE(present.place) + sizeof(struct record);
  *bytes = present.bytes;
  return true;
}

void image_begin(void) {
  next.step = STORE;
  next.begun = next.last = false;
  next.result = IMAGE_WORKING;
  next.place = present.place == 0;
  next.erased = next.received = next.checked = next.sum = 0;
  next.bytes = 0;
}

/* 0, or why the file is refused, from what has come of it. */
static uint16_t refused(const uint8_t *data, uint16_t bytes) {
  uint32_t whole = next.received + bytes;
  if (next.received == 0) {
    if (bytes < sizeof next.header) return FOE_NO_HEADER;
    memcpy(&next.header, data, sizeof next.header);
    if (next.header.magic != FILE_MAGIC) return FOE_NO_HEADER;
    if (next.header.product != objects.product) return FOE_WRONG_DEVICE;
    if (!fits(next.header.bytes)) return FOE_DISK_FULL;
    next.sum = crc32(0, data + sizeof next.header, bytes - sizeof next.header);
  } else {
    next.sum = crc32(next.sum, data, bytes);
  }
  whole -= sizeof next.header;
  if (whole > next.header.bytes) return FOE_WRONG_SUM;
  if (next.last && (whole != next.header.bytes || next.sum != next.header.sum)) return FOE_WRONG_SUM;
  return 0;
}

void image_append(const uint8_t *data, uint16_t bytes, bool last) {
  uint16_t whole_words = (uint16_t)((bytes + 3u) & ~3u);
  next.last = last;
  next.result = refused(data, bytes);
  if (next.result) return;
  next.result = IMAGE_WORKING;
  memset(next.chunk, 0xFF, sizeof next.chunk);
  memcpy(next.chunk, data, bytes);
  next.bytes = whole_words;
}

/* The next erase or write of the step; false if it has none left. */
static bool store(void) {
  uint32_t at = sizeof(struct record) + next.received;
  next.begun = true;
  if (next.erased < at + next.bytes) {
    flash_erase(FLASH_IMAGE(next.place) + next.erased);
    next.erased += FLASH_SECTOR;
    return true;
  }
  if (!next.bytes) return false;
  flash_write(FLASH_IMAGE(next.place) + at, next.chunk, next.bytes);
  next.received += next.bytes;
  next.bytes = 0;
  return true;
}

static void check(void) {
  uint32_t to = next.checked + PART < next.header.bytes ? next.checked + PART : next.header.bytes;
  if (next.checked == 0) next.sum = 0;
  next.sum = sum_of(next.sum, next.place, next.checked, to);
  next.checked = to;
  if (to < next.header.bytes) return;
  if (next.sum != next.header.sum) {
    next.result = FOE_FLASH;
    return;
  }
  next.record.magic = RECORD_MAGIC;
  next.record.number = present.number + 1;
  next.record.sum = record_sum(&next.record);
  next.record.unused = 0xFFFFFFFFu;
  flash_write(FLASH_IMAGE(next.place), &next.record, sizeof next.record);
  next.step = RECORD;
}

uint16_t image_work(void) {
  enum flash_state state = flash_state();
  if (next.result != IMAGE_WORKING) return next.result;
  if (state == FLASH_BUSY || parameters_state() == PARAMETERS_WORKING) return IMAGE_WORKING;
  if (state == FLASH_FAILED && next.begun) {
    next.result = FOE_FLASH;
  } else if (next.step == STORE) {
    if (!store()) {
      if (next.last) next.step = CHECK;
      if (!next.last) next.result = 0;
    }
  } else if (next.step == CHECK) {
    check();
  } else {
    present.place = next.place;
    present.number = next.record.number;
    present.bytes = next.header.bytes + sizeof next.header;
    next.result = 0;
  }
  return next.result;
}
