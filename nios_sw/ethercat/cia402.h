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
/* Transition 13. */
void cia402_fault(struct cia402 *machine);
/* Transition 11 from inside, when the master leaves OP; nothing in another state. */
void cia402_quick_stop(struct cia402 *machine);
/* Whether the machine is to give torque, and how it is to come to a stop. */
bool cia402_power(const struct cia402 *machine);
enum drive_ramp cia402_ramp(const struct cia402 *machine, const struct axis_objects *axis);
/* Bits 0 to 3, 5 and 6 and 4 (voltage) of the statusword. */
uint16_t cia402_status(const struct cia402 *machine);

#endif
