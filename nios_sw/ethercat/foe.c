/* SPDX-License-Identifier: Apache-2.0 */
/* File access over EtherCAT, see foe.h. An answer comes when the flash has done its work. If that takes longer than
 * BUSY_MS, the answer is BUSY, and the master sends its packet again. */
#include "foe.h"

#include <string.h>

#include "al.h"
#include "diagnosis.h"
#include "flash.h"
#include "image.h"
#include "mailbox.h"

#define BUSY_MS 100u /* SOEM waits 200 ms */
#define ROOM (MAILBOX_DATA - FOE_HEADER) /* data of a packet; a shorter one is the last */

#define READ 1
#define WRITE 2
#define DATA 3
#define ACKNOWLEDGE 4
#define ERROR 5
#define BUSY 6

static const char firmware[] = "firmware";

static struct {
  enum { IDLE, READING, WRITING } state;
  bool owes;       /* WRITING: the master waits for the answer to `packet` */
  bool stored;     /* WRITING: the image is complete */
  bool ended;      /* the last packet came or went */
  uint32_t packet; /* READING: the one sent last; WRITING: the one taken last */
  uint32_t asked_ms;
  uint32_t at, bytes, sent; /* READING: the file in flash, and how much of it the packets before had */
} transfer;

static uint8_t answer[MAILBOX_DATA];

void foe_start(void) { transfer.state = IDLE; }

static void send(uint8_t code, uint32_t value, uint16_t bytes) {
  answer[0] = code;
  answer[1] = 0;
  for (int i = 0; i < 4; ++i) answer[2 + i] = (uint8_t)(value >> 8 * i);
  mailbox_send(MAILBOX_FOE, answer, (uint16_t)(FOE_HEADER + bytes));
}

static void refuse(uint16_t code) {
  if (transfer.state == WRITING) diagnosis_note(DIAGNOSIS_NO_FIRMWARE, code, 0);
  transfer.state = IDLE;
  send(ERROR, code, 0);
}

/* Whether the file's name, which may end with zeros, is this one. */
static bool is_named(const uint8_t *name, uint16_t bytes, const char *wanted) {
  while (bytes && !name[bytes - 1]) --bytes;
  return bytes == strlen(wanted) && !memcmp(name, wanted, bytes);
}

/* 0, or why the request for a file is refused. */
static uint16_t refusal(uint32_t password, const uint8_t *name, uint16_t bytes) {
  if (!is_named(name, bytes, firmware)) return FOE_NOT_FOUND;
  if (al_state() != AL_BOOT) return FOE_BOOTSTRAP_ONLY;
  return password == FOE_PASSWORD ? 0 : FOE_NO_RIGHTS;
}

/* The packet, for the first time or again. */
static void send_packet(void) {
  uint32_t left = transfer.bytes - transfer.sent;
  uint16_t bytes = (uint16_t)(left < ROOM ? left : ROOM);
  flash_read(transfer.at + transfer.sent, answer + FOE_HEADER, bytes);
  transfer.ended = bytes < ROOM;
  send(DATA, transfer.packet, bytes);
}

static void read(uint16_t refused) {
  if (!refused && !image_current(&transfer.at, &transfer.bytes)) refused = FOE_NO_FILE;
  if (!refused && flash_state() == FLASH_BUSY) { /* of a transfer that was given up */
    send(BUSY, 0, 0);
    return;
  }
  if (refused) {
    refuse(refused);
    return;
  }
  transfer.state = READING;
  transfer.packet = 1;
  transfer.sent = 0;
  send_packet();
}

static void write(uint16_t refused) {
  if (refused) {
    refuse(refused);
    return;
  }
  transfer.state = WRITING;
  transfer.packet = 0;
  transfer.owes = true;
  transfer.ended = transfer.stored = false;
  image_begin();
}

static void acknowledged(uint32_t packet) {
  if (packet == transfer.packet) {
    if (transfer.ended) {
      transfer.state = IDLE;
      return;
    }
    transfer.sent += ROOM;
    ++transfer.packet;
  } else if (packet != transfer.packet - 1) {
    refuse(FOE_WRONG_PACKET);
    return;
  }
  send_packet(); /* the packet before was acknowledged: this one was lost */
}

static void take(uint32_t packet, const uint8_t *data, uint16_t bytes) {
  uint16_t found = image_work();
  if (packet == transfer.packet) {
    transfer.owes = true; /* sent again: only the answer is missing */
  } else if (packet != transfer.packet + 1 || transfer.ended || found == IMAGE_WORKING) {
    refuse(FOE_WRONG_PACKET);
  } else if (found) {
    refuse(found);
  } else {
    transfer.packet = packet;
    transfer.owes = true;
    transfer.ended = bytes < ROOM;
    image_append(data, bytes, transfer.ended);
  }
}

void foe_request(const uint8_t *data, uint16_t bytes, uint32_t now_ms) {
  uint32_t value = data[2] | (uint32_t)data[3] << 8 | (uint32_t)data[4] << 16 | (uint32_t)data[5] << 24;
  const uint8_t *rest = data + FOE_HEADER;
  bytes = (uint16_t)(bytes - FOE_HEADER);
  transfer.asked_ms = now_ms;
  if (data[0] == READ) {
    read(refusal(value, rest, bytes));
  } else if (data[0] == WRITE) {
    uint16_t refused = refusal(value, rest, bytes);
    if (!refused && transfer.state == WRITING && transfer.packet == 0) {
      transfer.owes = true; /* sent again after BUSY */
    } else {
      write(refused);
    }
  } else if (data[0] == DATA && transfer.state == WRITING) {
    take(value, rest, bytes);
  } else if (data[0] == ACKNOWLEDGE && transfer.state == READING) {
    acknowledged(value);
  } else if (data[0] == BUSY && transfer.state == READING) {
    send_packet();
  } else if (data[0] == ERROR) {
    transfer.state = IDLE; /* needs no answer */
  } else {
    refuse(FOE_ILLEGAL);
  }
}

bool foe_continue(uint32_t now_ms) {
  uint16_t found;
  if (transfer.state != WRITING) return false;
  found = image_work();
  if (!transfer.owes) return false;
  if (found == IMAGE_WORKING) {
    if (now_ms - transfer.asked_ms < BUSY_MS) return false;
    send(BUSY, 0, 0);
  } else if (found) {
    refuse(found);
  } else {
    if (transfer.ended && !transfer.stored) diagnosis_note(DIAGNOSIS_FIRMWARE, 0, 0);
    transfer.stored = transfer.ended;
    send(ACKNOWLEDGE, transfer.packet, 0);
  }
  transfer.owes = false;
  return true;
}
