/* SPDX-License-Identifier: Apache-2.0 */
/* Application layer state machine, see al.h. */
#include "al.h"

#include "application.h"
#include "cycle.h"
#include "diagnosis.h"
#include "dictionary.h"
#include "esc.h"
#include "guard.h"
#include "mailbox.h"
#include "pdo.h"

#define MANAGERS 8
#define MANAGERS_USED 4
#define SM_BYTE(name) (ESC_SM_##name(0) - ESC_SM_START(0)) /* place among the registers of a sync manager */
#define SM_MODE(mode, direction) ((mode) << ESC_SM_CONTROL_MODE_LSB | (direction) << ESC_SM_CONTROL_DIRECTION_LSB)
#define BUFFERS 0 /* mode */
#define MAILBOX 2
#define READS 0 /* direction: what the master does */
#define WRITES 1

uint8_t al_present;
static uint16_t code, halted;
static bool waiting; /* SAFEOP, OP requested: outputs, or SYNC0, have not come yet */
static bool outputs_seen, sync0_seen;
static bool identify; /* the master asks for the identification value (AL_CONTROL, bit 5) */
static uint32_t waiting_since;
static uint16_t process_bytes[2];

uint16_t al_code(void) { return code; }
uint16_t al_process_bytes(int side) { return process_bytes[side]; }
void al_outputs_seen(void) { outputs_seen = true; }
void al_sync0_seen(void) { sync0_seen = true; }

/* An error has the code, whatever else the master asks for; without one it may ask for the identification value. */
static void publish(void) {
  uint16_t status = al_present;
  if (code) {
    status |= ESC_AL_STATUS_ERROR_MASK;
  } else if (identify) {
    status |= ESC_AL_STATUS_IDENTIFICATION_MASK;
  }
  esc_write16(ESC_AL_STATUS_CODE, code || !identify ? code : objects.identification);
  esc_write16(ESC_AL_STATUS, status);
}

static void enter(uint8_t next) {
  uint8_t before = al_present;
  al_present = next;
  waiting = false;
  if (before == AL_OP && next != AL_OP) {
    application_leave_op(code == AL_WATCHDOG || code == AL_SYNC_ERROR || code == AL_SYNC_LOST);
  }
  if (next == AL_OP) application_enter_op();
  if (next != AL_OP) outputs_seen = sync0_seen = false; /* OP wants new ones */
  if (next == AL_INIT) mailbox_stop();
  if (before == AL_INIT && (next == AL_PREOP || next == AL_BOOT)) mailbox_start();
}

void al_start(void) {
  al_present = AL_INIT;
  code = halted = 0;
  waiting = outputs_seen = sync0_seen = identify = false;
  mailbox_stop();
  publish();
}

/* An error of this code from now on. */
static void fail(uint16_t why) {
  code = why;
  diagnosis_note(DIAGNOSIS_AL_ERROR, why, al_present);
}

void al_fault(uint16_t why) {
  fail(why);
  if (al_present == AL_OP) enter(AL_SAFEOP);
  waiting = false;
  publish();
}

void al_halt(uint16_t why) {
  halted = why;
  fail(why);
  enter(AL_INIT);
  publish();
}

/* Whether sync manager n is set up like this; mode: its buffers and direction. */
static bool is_set_up(int n, uint16_t start, uint16_t bytes, uint8_t mode) {
  uint8_t found[8];
  esc_read(ESC_SM_START(n), found, sizeof found);
  if (bytes == 0) return !(found[SM_BYTE(ACTIVATE)] & ESC_SM_ACTIVATE_ENABLE_MASK);
  return found[SM_BYTE(ACTIVATE)] & ESC_SM_ACTIVATE_ENABLE_MASK &&
         (found[SM_BYTE(START)] | found[SM_BYTE(START) + 1] << 8) == start &&
         (found[SM_BYTE(LENGTH)] | found[SM_BYTE(LENGTH) + 1] << 8) == bytes &&
         (found[SM_BYTE(CONTROL)] & (ESC_SM_CONTROL_MODE_MASK | ESC_SM_CONTROL_DIRECTION_MASK)) == mode;
}

/* The bootstrap mailbox is at the same place. */
static bool has_mailbox(void) {
  return is_set_up(0, MAILBOX_OUT, MAILBOX_BYTES, SM_MODE(MAILBOX, WRITES)) &&
         is_set_up(1, MAILBOX_IN, MAILBOX_BYTES, SM_MODE(MAILBOX, READS));
}

static uint16_t check_process_data(void) {
  if (!is_set_up(2, PROCESS_OUTPUTS, process_bytes[PDO_RX], SM_MODE(BUFFERS, WRITES))) return AL_INVALID_OUTPUTS;
  if (!is_set_up(3, PROCESS_INPUTS, process_bytes[PDO_TX], SM_MODE(BUFFERS, READS))) return AL_INVALID_INPUTS;
  return 0;
}

static uint16_t check_clock(uint32_t *found) {
  static uint32_t whole = CYCLE_NS; /* a cycle that is one of the control's, or some: no pass divides it again */
  uint8_t active = esc_read8(ESC_SYNC_ACTIVATION);
  uint32_t cycle = *found = esc_read32(ESC_SYNC0_CYCLE);
  bool sync0 = active & ESC_SYNC_ACTIVATION_CYCLIC_MASK && active & ESC_SYNC_ACTIVATION_SYNC0_MASK;
  if (objects.output_sync.type == SYNC0 && !sync0) return AL_INVALID_SYNC;
  if (!sync0 || cycle == whole) return 0;
  if (cycle < CYCLE_NS || cycle % CYCLE_NS) return AL_INVALID_CYCLE;
  whole = cycle;
  return 0;
}

bool al_clock_holds(uint32_t *cycle) { return !check_clock(cycle); }

/* PREOP to SAFEOP. */
static uint16_t check_safeop(void) {
  uint16_t found;
  uint32_t cycle;
  process_bytes[PDO_RX] = pdo_prepare(PDO_RX);
  process_bytes[PDO_TX] = pdo_prepare(PDO_TX);
  if (process_bytes[PDO_RX] == PDO_INVALID) return AL_OUTPUT_MAPPING;
  for (int n = MANAGERS_USED; n < MANAGERS; ++n) {
    if (esc_read8(ESC_SM_ACTIVATE(n)) & ESC_SM_ACTIVATE_ENABLE_MASK) return AL_INVALID_SYNC_MANAGER;
  }
  found = check_process_data();
  if (!found) found = check_clock(&cycle);
  return found;
}

static bool known(uint8_t wanted) {
  return wanted == AL_INIT || wanted == AL_PREOP || wanted == AL_BOOT || wanted == AL_SAFEOP ||
         wanted == AL_OP;
}

/* The code of the refusal, 0 if the state was entered or is being waited for. */
static uint16_t change(uint8_t wanted, uint32_t now_ms, int guard) {
  uint16_t found = 0;
  uint32_t cycle;
  if (!known(wanted)) return AL_UNKNOWN_STATE;
  if (halted && wanted != AL_INIT && wanted != AL_BOOT) return halted; /* BOOT brings another program */
  if (wanted == al_present) {
    waiting = false;
    return 0;
  }
  if (wanted == AL_BOOT) {
    if (al_present != AL_INIT) return AL_INVALID_CHANGE;
    if (!has_mailbox()) return AL_INVALID_BOOT_MAILBOX;
    enter(AL_BOOT);
    return 0;
  }
  if (al_present == AL_BOOT && wanted != AL_INIT) return AL_INVALID_CHANGE;
  if (wanted < al_present) {
    enter(wanted);
    return 0;
  }
  if (al_present == AL_INIT) {
    if (wanted != AL_PREOP) return AL_INVALID_CHANGE;
    if (!has_mailbox()) return AL_INVALID_MAILBOX;
    enter(AL_PREOP);
  } else if (al_present == AL_PREOP) {
    if (wanted != AL_SAFEOP) return AL_INVALID_CHANGE;
    /* It takes longer than a control pass may wait; in PREOP the pass touches nothing of it. */
    guard_leave(guard);
    found = check_safeop();
    guard_enter();
    if (!found) found = halted;
    if (found) return found;
    enter(AL_SAFEOP);
    application_inputs(); /* so that the first read finds some */
  } else {
    found = check_clock(&cycle);
    if (found) return found == AL_INVALID_SYNC ? AL_NO_SYNC : found;
    waiting = true; /* OP, when outputs have come */
    waiting_since = now_ms;
  }
  return 0;
}

static void request(uint16_t control, uint32_t now_ms, int guard) {
  uint8_t wanted = control & ESC_AL_CONTROL_STATE_MASK;
  bool acknowledge = control & ESC_AL_CONTROL_ACKNOWLEDGE_MASK;
  uint16_t refusal;
  identify = control & ESC_AL_CONTROL_IDENTIFICATION_MASK;
  if (code && !acknowledge && wanted > al_present) return; /* the error is to be acknowledged first */
  if (acknowledge || wanted == AL_INIT) code = 0;
  refusal = change(wanted, now_ms, guard);
  if (refusal) fail(refusal);
  publish(); /* while it waits too: without the error that was acknowledged */
}

/* A sync manager was changed by the master while it is in use. */
static void check_changed(void) {
  for (int n = 0; n < MANAGERS_USED; ++n) (void)esc_read8(ESC_SM_ACTIVATE(n)); /* clears the event */
  if (al_present >= AL_PREOP && !has_mailbox()) {
    fail(al_present == AL_BOOT ? AL_INVALID_BOOT_MAILBOX : AL_INVALID_MAILBOX);
    enter(AL_INIT);
    publish();
  } else if (al_present >= AL_SAFEOP && check_process_data()) {
    fail(check_process_data());
    enter(AL_PREOP);
    publish();
  }
}

void al_step(uint32_t now_ms) {
  uint32_t event = esc_read32(ESC_AL_EVENT);
  bool outputs, synchronous;
  int guard;
  if (!waiting && !(event & (ESC_AL_EVENT_SM_CHANGE_MASK | ESC_AL_EVENT_AL_CONTROL_MASK))) return;
  guard = guard_enter(); /* the pass may fall from OP by itself */
  if (event & ESC_AL_EVENT_SM_CHANGE_MASK) check_changed();
  if (event & ESC_AL_EVENT_AL_CONTROL_MASK) request(esc_read16(ESC_AL_CONTROL), now_ms, guard);
  outputs = outputs_seen || process_bytes[PDO_RX] == 0;
  synchronous = sync0_seen || objects.output_sync.type != SYNC0;
  if (waiting && outputs && synchronous) {
    enter(AL_OP);
    publish();
  } else if (waiting && now_ms - waiting_since > SAFEOP_OP_TIMEOUT_MS) {
    al_fault(outputs ? AL_NO_SYNC : AL_NO_OUTPUTS);
  }
  guard_leave(guard);
}
