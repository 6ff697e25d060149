/* SPDX-License-Identifier: Apache-2.0 */
/* SDO server: expedited, normal and segmented transfer, single entries and whole objects (CiA 301,
 * ETG.1000.6 5.6.2). One transfer at a time; a new one ends what was under way. */
#include <string.h>

#include "al.h"
#include "coe.h"
#include "dictionary.h"
#include "mailbox.h"
#include "parameters.h"

#define SDO_BYTES 8
#define BUFFER 640u
/* Data of a message after the headers: of a normal transfer, of a segment. */
#define NORMAL_ROOM (MAILBOX_DATA - COE_HEADER - SDO_BYTES)
#define SEGMENT_ROOM (MAILBOX_DATA - COE_HEADER - 1)

/* Command specifiers, bits 7:5. */
#define DOWNLOAD_SEGMENT 0
#define DOWNLOAD 1
#define UPLOAD 2
#define UPLOAD_SEGMENT 3
#define ABORT 4

static struct {
  enum { IDLE, UPLOADING, DOWNLOADING, STORING } state;
  uint16_t index;
  uint8_t subindex;
  bool complete;   /* the whole object */
  uint8_t toggle;  /* 0 or 0x10 */
  uint32_t total, done; /* bytes */
  uint8_t data[BUFFER];
} transfer;

static uint8_t answer[MAILBOX_DATA];

void sdo_start(void) { transfer.state = IDLE; }

static void put16(uint8_t *to, uint16_t value) {
  to[0] = (uint8_t)value;
  to[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t *to, uint32_t value) {
  put16(to, (uint16_t)value);
  put16(to + 2, (uint16_t)(value >> 16));
}

static uint32_t get32(const uint8_t *from) {
  return from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 | (uint32_t)from[3] << 24;
}

/* Sends `bytes` after the CoE header, which are in answer from COE_HEADER on. */
static void send(uint16_t bytes) {
  put16(answer, COE_SDO_RESPONSE << 12);
  mailbox_send(MAILBOX_COE, answer, (uint16_t)(COE_HEADER + bytes));
}

static uint8_t *begin(uint8_t command) {
  uint8_t *sdo = answer + COE_HEADER;
  memset(sdo, 0, SDO_BYTES);
  sdo[0] = command;
  put16(sdo + 1, transfer.index);
  sdo[3] = transfer.subindex;
  return sdo;
}

static void abort_transfer(uint32_t code) {
  put32(begin(ABORT << 5) + 4, code);
  transfer.state = IDLE;
  /* An abort is sent as a request, ETG.1000.6 5.6.2.7. */
  put16(answer, COE_SDO_REQUEST << 12);
  mailbox_send(MAILBOX_COE, answer, COE_HEADER + SDO_BYTES);
}

/* The answer to a download, which is in `answer`. What 1010 and 1011 began is to end before. */
static void confirm(void) {
  if ((transfer.index == PARAMETERS_SAVE || transfer.index == PARAMETERS_LOAD) && transfer.state == IDLE) {
    transfer.state = STORING;
  } else {
    send(SDO_BYTES);
  }
}

bool sdo_continue(void) {
  if (transfer.state != STORING || parameters_state() == PARAMETERS_WORKING) return false;
  if (parameters_state() == PARAMETERS_FAILED) {
    abort_transfer(ABORT_HARDWARE);
  } else {
    transfer.state = IDLE;
    send(SDO_BYTES);
  }
  return true;
}

/* Whether it was taken; if not, the abort has been sent. */
static bool store(void) {
  struct place place;
  bool preop = al_state() == AL_PREOP;
  uint32_t abort;
  if (transfer.complete) {
    abort = dictionary_put_all(transfer.index, transfer.subindex, transfer.data, transfer.done, preop);
  } else {
    abort = dictionary_locate(transfer.index, transfer.subindex, &place);
    if (!abort) abort = dictionary_put(&place, transfer.data, transfer.done, preop);
  }
  transfer.state = IDLE;
  if (abort) abort_transfer(abort);
  return !abort;
}

/* Whether it can be written at all; reported before the data are taken. */
static uint32_t writable(uint32_t bytes) {
  struct place place;
  uint32_t abort = dictionary_locate(transfer.index, transfer.complete ? 0 : transfer.subindex, &place);
  if (abort) return abort;
  if (transfer.complete) return dictionary_writable(place.object) ? 0 : ABORT_READ_ONLY;
  if (!(place.entry->flags & ENTRY_WRITE)) return ABORT_READ_ONLY;
  if (place.entry->flags & ENTRY_PREOP && al_state() != AL_PREOP) return ABORT_STATE;
  if (place.entry->type == TYPE_STRING) return bytes > place.entry->bytes ? ABORT_TOO_LONG : 0;
  return bytes != place.entry->bytes ? ABORT_LENGTH : 0;
}

static void download(const uint8_t *sdo, uint16_t bytes) {
  bool expedited = sdo[0] & 2u, size_told = sdo[0] & 1u;
  const uint8_t *data = sdo + 4;
  uint32_t given = 4, abort;
  transfer.complete = sdo[0] & 0x10u;
  if (expedited) {
    if (size_told) given = 4u - (sdo[0] >> 2 & 3u);
    transfer.total = given;
    if (!size_told) { /* as many as the entry has */
      struct place place;
      if (!dictionary_locate(transfer.index, transfer.subindex, &place) && place.entry->bytes < 4) {
        transfer.total = given = place.entry->bytes;
      }
    }
  } else {
    transfer.total = get32(sdo + 4);
    data = sdo + SDO_BYTES;
    given = (uint32_t)(bytes - SDO_BYTES);
    if (given > transfer.total) given = transfer.total;
  }
  abort = writable(transfer.total);
  if (!abort && transfer.total > BUFFER) abort = ABORT_MEMORY;
  if (abort) {
    abort_transfer(abort);
    return;
  }
  memcpy(transfer.data, data, given);
  transfer.done = given;
  transfer.toggle = 0;
  transfer.state = DOWNLOADING;
  if (transfer.done == transfer.total && !store()) return;
  begin(3 << 5);
  confirm();
}

static void download_segment(const uint8_t *sdo, uint16_t bytes) {
  uint32_t given = (uint32_t)(bytes - 1);
  uint8_t toggle = sdo[0] & 0x10u;
  if (transfer.state != DOWNLOADING) {
    abort_transfer(ABORT_COMMAND);
    return;
  }
  if (toggle != transfer.toggle) {
    abort_transfer(ABORT_TOGGLE);
    return;
  }
  if (bytes == SDO_BYTES) given = 7u - (sdo[0] >> 1 & 7u);
  if (given > transfer.total - transfer.done) {
    abort_transfer(ABORT_TOO_LONG);
    return;
  }
  memcpy(transfer.data + transfer.done, sdo + 1, given);
  transfer.done += given;
  transfer.toggle ^= 0x10u;
  if (sdo[0] & 1u) {
    if (transfer.done != transfer.total) {
      abort_transfer(ABORT_TOO_SHORT);
      return;
    }
    if (!store()) return;
  }
  memset(answer + COE_HEADER, 0, SDO_BYTES);
  answer[COE_HEADER] = (uint8_t)(1 << 5 | toggle);
  confirm();
}

static void upload(const uint8_t *command) {
  struct place place;
  uint16_t bytes = 0;
  uint32_t abort;
  uint8_t *sdo;
  transfer.complete = command[0] & 0x10u;
  if (transfer.complete) {
    abort = dictionary_get_all(transfer.index, transfer.subindex, transfer.data, BUFFER, &bytes);
  } else {
    abort = dictionary_locate(transfer.index, transfer.subindex, &place);
    if (!abort) {
      bytes = dictionary_length(&place);
      dictionary_get(&place, transfer.data);
    }
  }
  if (abort) {
    abort_transfer(abort);
    return;
  }
  transfer.total = bytes;
  transfer.done = 0;
  transfer.toggle = 0;
  if (bytes >= 1 && bytes <= 4) {
    sdo = begin((uint8_t)(UPLOAD << 5 | (4 - bytes) << 2 | 3));
    memcpy(sdo + 4, transfer.data, bytes);
    transfer.state = IDLE;
    send(SDO_BYTES);
    return;
  }
  sdo = begin(UPLOAD << 5 | 1);
  put32(sdo + 4, bytes);
  transfer.done = bytes < NORMAL_ROOM ? bytes : NORMAL_ROOM;
  memcpy(sdo + SDO_BYTES, transfer.data, transfer.done);
  transfer.state = transfer.done < transfer.total ? UPLOADING : IDLE;
  send((uint16_t)(SDO_BYTES + transfer.done));
}

static void upload_segment(const uint8_t *command) {
  uint8_t *sdo = answer + COE_HEADER;
  uint32_t bytes = transfer.total - transfer.done;
  bool last = bytes <= SEGMENT_ROOM;
  if (transfer.state != UPLOADING) {
    abort_transfer(ABORT_COMMAND);
    return;
  }
  if ((command[0] & 0x10u) != transfer.toggle) {
    abort_transfer(ABORT_TOGGLE);
    return;
  }
  if (!last) bytes = SEGMENT_ROOM;
  memset(sdo, 0, SDO_BYTES);
  sdo[0] = (uint8_t)(transfer.toggle | last);
  if (bytes < 7) sdo[0] |= (uint8_t)((7 - bytes) << 1);
  memcpy(sdo + 1, transfer.data + transfer.done, bytes);
  transfer.done += bytes;
  transfer.toggle ^= 0x10u;
  if (last) transfer.state = IDLE;
  send((uint16_t)(bytes < 7 ? SDO_BYTES : 1 + bytes));
}

void sdo_request(const uint8_t *sdo, uint16_t bytes) {
  uint8_t command = sdo[0] >> 5;
  if (bytes < SDO_BYTES) {
    const uint8_t short_answer[4] = {1, 0, 6, 0};
    mailbox_send(MAILBOX_ERROR, short_answer, sizeof short_answer);
    return;
  }
  if (command == DOWNLOAD || command == UPLOAD) {
    transfer.state = IDLE;
    transfer.index = (uint16_t)(sdo[1] | sdo[2] << 8);
    transfer.subindex = sdo[3];
  }
  switch (command) {
    case DOWNLOAD_SEGMENT:
      download_segment(sdo, bytes);
      break;
    case DOWNLOAD:
      download(sdo, bytes);
      break;
    case UPLOAD:
      upload(sdo);
      break;
    case UPLOAD_SEGMENT:
      upload_segment(sdo);
      break;
    case ABORT:
      transfer.state = IDLE; /* needs no answer */
      break;
    default:
      abort_transfer(ABORT_COMMAND);
  }
}
