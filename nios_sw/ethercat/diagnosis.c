/* SPDX-License-Identifier: Apache-2.0 */
/* Diagnosis history, see diagnosis.h. */
#include "diagnosis.h"

#include <stdbool.h>
#include <string.h>

#include "application.h"
#include "dictionary.h"
#include "esc.h"
#include "guard.h"

#define QUEUE 32u /* noted and not yet in the history; more than the control pass notes in one cycle */
#define FIRST 6u  /* subindex of the first message */
#define ACKNOWLEDGED 3u
#define FLAGS 5u
/* Bits of the flags: the kinds 0 info, 1 warning, 2 error that are off begin at bit 1. */
#define KIND_OFF(kind) (2u << (kind))
#define KEEPS 0x10u /* new messages are dropped until old ones are acknowledged; otherwise the oldest is overwritten */
#define LOST 0x20u  /* one was overwritten or dropped that nobody had acknowledged */
#define WRITABLE (KIND_OFF(0) | KIND_OFF(1) | KIND_OFF(2) | KEEPS)
/* Diagnosis codes, in the lower word: of the manufacturer, an emergency's error code. */
#define OF_MANUFACTURER 0xE000u
#define OF_EMERGENCY 0xE800u
#define PARAMETERS 2u

static const uint8_t kinds[] = DIAGNOSIS_KINDS; /* by the number of the text */
static struct {
  uint16_t text, code;
  uint8_t place;
} queue[QUEUE];
static uint8_t queue_put, queue_taken; /* rising */
static bool dropped;           /* the queue was full */
static uint8_t unacknowledged; /* messages */

void diagnosis_start(void) { queue_put = queue_taken = unacknowledged = dropped = 0; }

void diagnosis_note(uint16_t text, uint16_t code, uint8_t place) {
  int guard = guard_enter();
  uint8_t last = queue_put % QUEUE;
  if ((uint8_t)(queue_put - queue_taken) == QUEUE) {
    dropped = true;
  } else {
    queue[last].text = text;
    queue[last].code = code;
    queue[last].place = place;
    ++queue_put;
  }
  guard_leave(guard);
}

static uint8_t *put(uint8_t *to, uint32_t value, int bytes) {
  for (; bytes; --bytes, value >>= 8) *to++ = (uint8_t)value;
  return to;
}

/* The system time of the distributed clocks [ns], local time if they are not set up. All of it is that of its first
 * byte's read. */
static uint8_t *put_time(uint8_t *to) {
  esc_read(ESC_SYSTEM_TIME, to, 8);
  return to + 8;
}

static void enter(uint16_t text, uint16_t code, uint8_t place) {
  uint8_t slot = objects.diagnosis.newest ? (uint8_t)((objects.diagnosis.newest - FIRST + 1u) % DIAGNOSIS_MESSAGES) : 0;
  uint8_t *to = objects.diagnosis_message[slot];
  if (unacknowledged == DIAGNOSIS_MESSAGES) {
    objects.diagnosis.flags |= LOST;
    if (objects.diagnosis.flags & KEEPS) return;
    --unacknowledged;
  }
  if (objects.diagnosis.acknowledged == slot + FIRST) objects.diagnosis.acknowledged = 0;
  to = put(to, (text == DIAGNOSIS_AXIS_ERROR ? OF_EMERGENCY : OF_MANUFACTURER) | (uint32_t)code << 16, 4);
  to = put(to, kinds[text] | PARAMETERS << 8, 2);
  to = put_time(put(to, text, 2));
  to = put(put(to, TYPE_U16, 2), code, 2);
  put(put(to, TYPE_U8, 2), place, 1);
  objects.diagnosis.newest = (uint8_t)(slot + FIRST);
  objects.diagnosis.available = 1;
  ++unacknowledged;
}

void diagnosis_work(void) {
  while (queue_taken != queue_put) {
    uint8_t first = queue_taken % QUEUE;
    if (!(objects.diagnosis.flags & KIND_OFF(kinds[queue[first].text]))) {
      enter(queue[first].text, queue[first].code, queue[first].place);
    }
    ++queue_taken;
  }
  if (dropped) objects.diagnosis.flags |= LOST;
  dropped = false;
}

static uint32_t acknowledge(uint32_t subindex) {
  uint32_t slot = subindex - FIRST, newer;
  if (subindex == 0) {
    memset(objects.diagnosis_message, 0, sizeof objects.diagnosis_message);
    objects.diagnosis.newest = 0;
    newer = 0;
  } else {
    if (subindex < FIRST || slot >= DIAGNOSIS_MESSAGES) return ABORT_RANGE;
    if (!objects.diagnosis_message[slot][1]) return ABORT_RANGE; /* there is none: no diagnosis code */
    newer = (objects.diagnosis.newest - subindex + DIAGNOSIS_MESSAGES) % DIAGNOSIS_MESSAGES;
    if (newer >= unacknowledged) return 0; /* it is already */
  }
  unacknowledged = (uint8_t)newer;
  objects.diagnosis.acknowledged = (uint8_t)subindex;
  objects.diagnosis.flags &= (uint16_t)~LOST;
  if (!newer) objects.diagnosis.available = 0;
  return 0;
}

uint32_t diagnosis_write(uint8_t subindex, uint32_t value) {
  if (subindex == ACKNOWLEDGED) return acknowledge(value);
  if (subindex != FLAGS || (value ^ objects.diagnosis.flags) & ~WRITABLE) return ABORT_RANGE;
  objects.diagnosis.flags = (uint16_t)value;
  return 0;
}

void diagnosis_read(uint8_t subindex) {
  if (subindex == objects.diagnosis.newest && !(objects.diagnosis.flags & KEEPS)) objects.diagnosis.available = 0;
}
