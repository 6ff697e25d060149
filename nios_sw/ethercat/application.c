/* SPDX-License-Identifier: Apache-2.0 */
/* The application of the slave controller, see application.h. */
#include "application.h"

#include <string.h>

#include "al.h"
#include "axis.h"
#include "coe.h"
#include "cycle.h"
#include "diagnosis.h"
#include "dictionary.h"
#include "esc.h"
#include "image.h"
#include "mailbox.h"
#include "parameters.h"
#include "pdo.h"
#include "probe.h"

#define OUTPUTS_EVENT (1u << (ESC_AL_EVENT_SM_LSB + 2)) /* sync manager 2 */
#define SETTINGS 16 /* settings on their way to the law */
#define COMMUNICATION 0x7500u
#define ERROR_ANY 0x01u /* bits of the error register */
#define ERROR_COMMUNICATION 0x10u
#define ERROR_PROFILE 0x20u
#define IO_SHIFT 16 /* of the inputs and outputs 1 to 8 in 60FD and 60FE */
#define FREE_RUN 0 /* in 1C32:01 */

static uint32_t cycles, since_outputs, since_sync0; /* in control cycles */
static uint32_t sync0_cycle; /* ns, in this pass */
static uint64_t missed_after;          /* 100 ns since the outputs, when the next cycle of the master is missed */
static struct {
  uint16_t index;
  uint8_t subindex;
} settings[SETTINGS];
static uint8_t settings_put, settings_given; /* rising: the background's, the control pass' */
static uint32_t setting_number;

void application_start(void) {
  dictionary_reset();
  objects.output_sync.minimum = objects.input_sync.minimum = CYCLE_NS;
  diagnosis_start();
  image_start();
  cycles = since_outputs = setting_number = 0;
  settings_put = settings_given = 0;
  for (int n = 0; n < AXES; ++n) axis_start(n);
  parameters_start();
  al_start();
}

void application_written(uint16_t index, uint8_t subindex) {
  uint8_t last = settings_put % SETTINGS;
  if (index < 0x2000u || index > 0x2002u || (uint8_t)(settings_put - settings_given) == SETTINGS) return;
  settings[last].index = index;
  settings[last].subindex = subindex;
  ++settings_put;
}

void application_errors(void) {
  uint8_t found = 0;
  for (int n = 0; n < AXES; ++n) {
    uint16_t error = objects.axis[n].error_code;
    if (error) found |= ERROR_ANY | (error == COMMUNICATION ? ERROR_COMMUNICATION : ERROR_PROFILE);
  }
  objects.error_register = found;
}

uint32_t application_sync0_ns(void) { return objects.output_sync.type == SYNC0 ? sync0_cycle : 0; }

void application_enter_op(void) {
  since_outputs = since_sync0 = 0;
  missed_after = axis_period_100ns(0);
  for (int n = 0; n < AXES; ++n) axis_enter_op(n);
}

void application_leave_op(bool fault) {
  for (int n = 0; n < AXES; ++n) axis_leave_op(n, fault ? COMMUNICATION : 0);
  uint8_t mode = objects.output_error_mode;
  objects.digital_outputs =
      (uint8_t)((objects.digital_outputs & ~mode) | (objects.output_error_value & mode));
}

void application_inputs(void) {
  uint16_t bytes = al_process_bytes(PDO_TX);
  if (!bytes) return;
  pdo_inputs();
  esc_write(PROCESS_INPUTS, pdo_image[PDO_TX].words, bytes);
}

/* Whether SYNC0 pulses come as 1C32 wants it: not more than two of its cycles apart. */
static bool sync0_comes(uint32_t event) {
  if (event & ESC_AL_EVENT_SYNC0_MASK) {
    (void)esc_read8(ESC_SYNC_STATUS_0); /* clears the event */
    since_sync0 = 0;
    al_sync0_seen();
  } else if (since_sync0 < 0xFFFFFFu) {
    ++since_sync0;
  }
  return al_clock_holds(&sync0_cycle) && (uint64_t)since_sync0 * CYCLE_NS <= 2u * (uint64_t)sync0_cycle;
}

/* Fetches the newest outputs if some came. */
static bool fetch_outputs(uint32_t event) {
  uint16_t bytes = al_process_bytes(PDO_RX);
  if (!(event & OUTPUTS_EVENT) || !bytes) return false;
  esc_fetch(PROCESS_OUTPUTS, pdo_image[PDO_RX].words, bytes);
  return true;
}

/* Takes outputs that were fetched; whether there were any in OP. */
static bool take_outputs(bool came) {
  uint16_t limit = objects.sync_error_limit;
  uint64_t period, since;
  if (came) {
    al_outputs_seen();
    objects.output_sync.cycle = objects.input_sync.cycle =
        objects.output_sync.type == SYNC0 ? sync0_cycle : since_outputs * CYCLE_NS;
    since_outputs = 0;
    missed_after = axis_period_100ns(0);
    objects.output_sync.error = 0;
    if (al_state() != AL_OP) return false;
    pdo_outputs();
    return true;
  }
  if (al_state() != AL_OP || !al_process_bytes(PDO_RX)) return false;
  if (!(esc_read8(ESC_WATCHDOG_STATUS) & ESC_WATCHDOG_STATUS_ALIVE_MASK)) {
    al_fault(AL_WATCHDOG);
    return false;
  }
  if (objects.output_sync.type == FREE_RUN) return false; /* only the watchdog counts */
  period = axis_period_100ns(0);
  since = (uint64_t)since_outputs * CYCLE_100NS;
  if (since >= missed_after && objects.output_sync.missed < 0xFFFFu) {
    ++objects.output_sync.missed;
    missed_after += period;
  }
  if (limit && since >= (limit + 1u) * period) {
    objects.output_sync.error = 1;
    al_fault(AL_SYNC_ERROR);
  }
  return false;
}

/* Of 8A00, but those in the mask of an axis are that axis'. */
static uint8_t digital_outputs(void) {
  uint32_t outputs = (uint32_t)objects.digital_outputs << IO_SHIFT;
  if (al_state() == AL_OP) {
    for (int n = 0; n < AXES; ++n) {
      const struct axis_objects *o = &objects.axis[n];
      if (o->output_mask) outputs = (outputs & ~o->output_mask) | (o->outputs & o->output_mask);
    }
  }
  return (uint8_t)(outputs >> IO_SHIFT);
}

static void send_setting(struct command *command) {
  struct place place;
  uint8_t first = settings_given % SETTINGS;
  if (settings_put != settings_given &&
      !dictionary_locate(settings[first].index, settings[first].subindex, &place)) {
    command->setting_index = settings[first].index;
    command->setting_subindex = settings[first].subindex;
    memcpy(&command->setting_value, place.data, sizeof command->setting_value);
    ++settings_given;
    ++setting_number;
  }
  command->setting_number = setting_number;
}

void application_cycle(const struct feedback *feedback, struct command *command) {
  uint8_t state = al_state();
  uint32_t event = state >= AL_SAFEOP ? esc_read32(ESC_AL_EVENT) : 0;
  bool came, fresh = false;
  ++cycles;
  if (since_outputs < 0xFFFFFFu) ++since_outputs;
  if (state >= AL_SAFEOP && objects.output_sync.type == SYNC0 && !sync0_comes(event) && state == AL_OP) {
    objects.output_sync.error = 1;
    al_fault(AL_SYNC_LOST);
  }
  came = state >= AL_SAFEOP && fetch_outputs(event);
  objects.digital_inputs = feedback->digital_inputs;
  probe_inputs(feedback);
  for (int n = 0; n < AXES; ++n) {
    objects.pose[n] = feedback->pose[n];
    objects.axis[n].inputs = (uint32_t)feedback->digital_inputs << IO_SHIFT | feedback->axis[n].switches;
  }
  if (state >= AL_SAFEOP) {
    /* Outputs can come between the read of the event and the fetch in each cycle, at one phase of the bus. The fetch
     * then already gets the new ones and ends their event, so the next cycle finds none: half of them would be
     * missed. A second look, later than a fetch begins, finds them in each cycle. */
    if (!came) came = fetch_outputs(esc_read32(ESC_AL_EVENT));
    fresh = take_outputs(came);
  }
  axis_cycles(feedback, fresh, command);
  command->digital_outputs = digital_outputs();
  send_setting(command);
  if (al_state() >= AL_SAFEOP) application_inputs();
}

void application_background(void) {
  uint32_t now_ms = cycles / CYCLES_PER_MS;
  al_step(now_ms);
  parameters_work();
  diagnosis_work();
  mailbox_step(now_ms);
}
