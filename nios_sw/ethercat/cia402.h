/* SPDX-License-Identifier: Apache-2.0 */
/* State machine of a drive (CiA 402, IEC 61800-7-201): states, controlword, statusword; it moves nothing. */
#ifndef ETHERCAT_CIA402_H
#define ETHERCAT_CIA402_H

#include <stdbool.h>
#include <stdint.h>

#include "gen/objects.h"

enum drive_state {
  DRIVE_NOT_READY,
  DRIVE_DISABLED, /* switch on disabled */
  DRIVE_READY,    /* ready to switch on */
  DRIVE_ON,       /* switched on */
  DRIVE_ENABLED,  /* operation enabled */
  DRIVE_QUICK_STOP,
  DRIVE_REACTION, /* fault reaction active */
  DRIVE_FAULT
};

enum drive_ramp { RAMP_NONE, RAMP_PROFILE, RAMP_QUICK_STOP };

struct cia402 {
  enum drive_state state;
  enum drive_state after; /* of ENABLED: where it goes when the ramp has ended; ENABLED: nowhere */
  bool reset_was;         /* bit 7 of the last controlword */
};

#define CONTROL_HALT 0x0100u

void cia402_start(struct cia402 *machine);
/* One transition at most. remote: the controlword is valid (OP); standstill: the axis rests. */
void cia402_step(struct cia402 *machine, const struct axis_objects *axis, bool remote, bool standstill);
/* The step of most cycles: ENABLED, and the master wants that. Whether it was; standstill does not count for it. */
static inline bool cia402_stays(struct cia402 *machine, const struct axis_objects *axis, bool remote) {
  if (machine->state != DRIVE_ENABLED || !remote || (axis->controlword & 0x8Fu) != 0x0Fu) return false;
  machine->after = DRIVE_ENABLED;
  machine->reset_was = false;
  return true;
}
/* Transition 13. */
void cia402_fault(struct cia402 *machine);
/* Transition 11 from inside, when the master leaves OP; nothing in another state. */
void cia402_quick_stop(struct cia402 *machine);
/* Whether the machine is to give torque, and how it is to come to a stop. */
static inline bool cia402_power(const struct cia402 *machine) {
  return machine->state == DRIVE_ENABLED || machine->state == DRIVE_QUICK_STOP ||
         machine->state == DRIVE_REACTION;
}
enum drive_ramp cia402_ramp(const struct cia402 *machine, const struct axis_objects *axis);
/* Whether cia402_ramp is RAMP_NONE because nothing asks for one in ENABLED: most cycles. */
static inline bool cia402_goes_on(const struct cia402 *machine, const struct axis_objects *axis) {
  return machine->state == DRIVE_ENABLED && machine->after == DRIVE_ENABLED && !(axis->controlword & CONTROL_HALT);
}
/* Bits 0 to 3, 5 and 6 and 4 (voltage) of the statusword. */
static inline uint16_t cia402_status(const struct cia402 *machine) {
  static const uint8_t bits[] = {0x00, 0x40, 0x31, 0x33, 0x37, 0x17, 0x1F, 0x08};
  return bits[machine->state];
}

#endif
