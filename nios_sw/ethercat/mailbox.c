/* SPDX-License-Identifier: Apache-2.0 */
/* Mailbox, see mailbox.h. */
#include "mailbox.h"

#include <string.h>

#include "al.h"
#include "coe.h"
#include "esc.h"
#include "foe.h"

#define UNSUPPORTED_PROTOCOL 2
#define TOO_SHORT 6
#define INVALID_SIZE 8

struct message {
  _Alignas(4) uint8_t bytes[MAILBOX_BYTES]; /* header: length 2, address 2, channel 1, type 4 bits, counter 3 bits */
};

static struct message in, sent[2]; /* sent[newest] is in the mailbox, or the last that was read there */
static uint8_t newest;
static bool running, waits; /* the newest waits for the one before it, which the master requested again */
static uint8_t counter_in, counter_out;

void mailbox_start(void) {
  running = true;
  counter_in = counter_out = 0;
  waits = false;
  memset(sent, 0, sizeof sent);
  coe_start();
  foe_start();
}

void mailbox_stop(void) { running = false; }

static uint16_t length_of(const struct message *message) {
  return (uint16_t)(message->bytes[0] | message->bytes[1] << 8);
}

static bool is_full(int manager) {
  return esc_read8(ESC_SM_STATUS(manager)) & ESC_SM_STATUS_FULL_MASK;
}

/* The last byte hands the mailbox over. */
static void place(const struct message *message) {
  uint16_t bytes = (uint16_t)(MAILBOX_HEADER + length_of(message));
  esc_write(MAILBOX_IN, message->bytes, bytes);
  if (bytes < MAILBOX_BYTES) esc_write8(MAILBOX_IN + MAILBOX_BYTES - 1u, 0);
}

bool mailbox_send(uint8_t type, const uint8_t *data, uint16_t bytes) {
  struct message *out;
  if (waits || is_full(1)) return false;
  newest ^= 1;
  out = &sent[newest];
  counter_out = (uint8_t)(counter_out % 7u + 1u);
  memset(out->bytes, 0, MAILBOX_HEADER);
  out->bytes[0] = (uint8_t)bytes;
  out->bytes[1] = (uint8_t)(bytes >> 8);
  out->bytes[5] = (uint8_t)(type | counter_out << 4);
  memcpy(out->bytes + MAILBOX_HEADER, data, bytes);
  place(out);
  return true;
}

static void refuse(uint8_t detail) {
  const uint8_t answer[4] = {1, 0, detail, 0};
  mailbox_send(MAILBOX_ERROR, answer, sizeof answer);
}

/* The master lost what it read last. If a newer message is in the mailbox already, that one is
 * taken out and waits. */
static void repeat(void) {
  uint8_t wanted = esc_read8(ESC_SM_ACTIVATE(1)) & ESC_SM_ACTIVATE_REPEAT_MASK;
  uint8_t done = esc_read8(ESC_SM_PDI(1)) & ESC_SM_PDI_REPEAT_ACK_MASK;
  const struct message *lost = &sent[newest];
  if (wanted == done) return;
  if (is_full(1)) {
    esc_write8(ESC_SM_PDI(1), done | ESC_SM_PDI_DISABLE_MASK);
    esc_write8(ESC_SM_PDI(1), done);
    lost = &sent[newest ^ 1];
    waits = true;
  }
  if (length_of(lost)) place(lost);
  esc_write8(ESC_SM_PDI(1), wanted);
}

static void take(uint32_t now_ms) {
  uint16_t bytes;
  uint8_t type, counter;
  esc_read(MAILBOX_OUT, in.bytes, MAILBOX_HEADER);
  bytes = length_of(&in);
  if (bytes > MAILBOX_DATA) {
    esc_read8(MAILBOX_OUT + MAILBOX_BYTES - 1u);
    refuse(INVALID_SIZE);
    return;
  }
  esc_read(MAILBOX_OUT + MAILBOX_HEADER, in.bytes + MAILBOX_HEADER, bytes);
  if (bytes < MAILBOX_DATA) esc_read8(MAILBOX_OUT + MAILBOX_BYTES - 1u);
  type = in.bytes[5] & 0xFu;
  counter = in.bytes[5] >> 4 & 7u;
  if (counter && counter == counter_in) return; /* sent twice */
  counter_in = counter;
  if (type != MAILBOX_FOE && (type != MAILBOX_COE || al_state() == AL_BOOT)) {
    refuse(UNSUPPORTED_PROTOCOL);
  } else if (bytes < (type == MAILBOX_FOE ? FOE_HEADER : COE_HEADER)) {
    refuse(TOO_SHORT);
  } else if (type == MAILBOX_FOE) {
    foe_request(in.bytes + MAILBOX_HEADER, bytes, now_ms);
  } else {
    coe_request(in.bytes + MAILBOX_HEADER, bytes);
  }
}

void mailbox_step(uint32_t now_ms) {
  if (!running) return;
  repeat();
  if (is_full(1)) return; /* what is there goes first */
  if (waits) {
    waits = false;
    place(&sent[newest]);
    return;
  }
  if (foe_continue(now_ms)) return;
  if (al_state() != AL_BOOT && coe_continue()) return;
  if (is_full(0)) take(now_ms);
}
