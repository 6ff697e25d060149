/* SPDX-License-Identifier: Apache-2.0 */
/* State machine of a drive, see cia402.h. Numbers of transitions are those of CiA 402. */
#include "cia402.h"

enum command {
  NO_COMMAND,
  DISABLE_VOLTAGE,
  QUICK_STOP,
  SHUTDOWN,
  SWITCH_ON, /* in ENABLED: disable operation */
  ENABLE_OPERATION
};

/* Commands by the bits that count for each; a set bit 7 is no command. */
static enum command command_of(uint16_t word) {
  if (word & 0x80u) return NO_COMMAND;
  if (!(word & 0x02u)) return DISABLE_VOLTAGE;
  if (!(word & 0x04u)) return QUICK_STOP;
  if (!(word & 0x01u)) return SHUTDOWN;
  return word & 0x08u ? ENABLE_OPERATION : SWITCH_ON;
}

void cia402_start(struct cia402 *machine) {
  machine->state = DRIVE_NOT_READY; /* 0 */
  machine->after = DRIVE_ENABLED;
  machine->reset_was = true; /* a set bit 7 is no edge */
}

void cia402_fault(struct cia402 *machine) {
  if (machine->state == DRIVE_FAULT || machine->state == DRIVE_REACTION) return;
  /* Without power there is nothing to bring to a stop. */
  machine->state = cia402_power(machine) ? DRIVE_REACTION : DRIVE_FAULT; /* 13, 14 */
}

void cia402_quick_stop(struct cia402 *machine) {
  if (machine->state == DRIVE_ENABLED) machine->state = DRIVE_QUICK_STOP;
}

/* A ramp of ENABLED leads to `next`, at once with option 0. */
static void leave(struct cia402 *machine, enum drive_state next, int16_t option) {
  if (option) {
    machine->after = next;
  } else {
    machine->state = next;
  }
}

static void enabled(struct cia402 *machine, const struct axis_objects *axis, enum command command) {
  switch (command) {
    case DISABLE_VOLTAGE:
      machine->state = DRIVE_DISABLED; /* 9 */
      break;
    case QUICK_STOP:
      machine->state = DRIVE_QUICK_STOP; /* 11 */
      break;
    case SHUTDOWN:
      leave(machine, DRIVE_READY, axis->shutdown_option); /* 8 */
      break;
    case SWITCH_ON:
      leave(machine, DRIVE_ON, axis->disable_option); /* 5 */
      break;
    case ENABLE_OPERATION:
      machine->after = DRIVE_ENABLED;
      break;
    default:
      break;
  }
}

void cia402_step(struct cia402 *machine, const struct axis_objects *axis, bool remote, bool standstill) {
  enum command command = remote ? command_of(axis->controlword) : NO_COMMAND;
  bool reset = remote && axis->controlword & 0x80u;
  bool edge = reset && !machine->reset_was;
  machine->reset_was = reset;
  switch (machine->state) {
    case DRIVE_NOT_READY:
      machine->state = DRIVE_DISABLED; /* 1 */
      break;
    case DRIVE_DISABLED:
      if (command == SHUTDOWN) machine->state = DRIVE_READY; /* 2 */
      break;
    case DRIVE_READY:
      if (command == DISABLE_VOLTAGE || command == QUICK_STOP) machine->state = DRIVE_DISABLED; /* 7 */
      if (command == SWITCH_ON || command == ENABLE_OPERATION) machine->state = DRIVE_ON;       /* 3 */
      break;
    case DRIVE_ON:
      if (command == DISABLE_VOLTAGE || command == QUICK_STOP) machine->state = DRIVE_DISABLED; /* 10 */
      if (command == SHUTDOWN) machine->state = DRIVE_READY;                                    /* 6 */
      if (command == ENABLE_OPERATION) machine->state = DRIVE_ENABLED;                          /* 4 */
      machine->after = DRIVE_ENABLED;
      break;
    case DRIVE_ENABLED:
      enabled(machine, axis, command);
      if (machine->state == DRIVE_ENABLED && standstill) machine->state = machine->after; /* 5, 8 */
      break;
    case DRIVE_QUICK_STOP:
      /* Outside of OP nobody could bring it on from here. */
      if (command == DISABLE_VOLTAGE || ((axis->quick_stop_option < 5 || !remote) && standstill) ||
          axis->quick_stop_option == 0) {
        machine->state = DRIVE_DISABLED; /* 12 */
      } else if (command == ENABLE_OPERATION && axis->quick_stop_option >= 5) {
        machine->state = DRIVE_ENABLED; /* 16 */
        machine->after = DRIVE_ENABLED;
      }
      break;
    case DRIVE_REACTION:
      if (standstill || axis->fault_option == 0) machine->state = DRIVE_FAULT; /* 14 */
      break;
    case DRIVE_FAULT:
      if (edge) machine->state = DRIVE_DISABLED; /* 15 */
      break;
  }
}

enum drive_ramp cia402_ramp(const struct cia402 *machine, const struct axis_objects *axis) {
  switch (machine->state) {
    case DRIVE_ENABLED:
      if (machine->after != DRIVE_ENABLED) return RAMP_PROFILE;
      if (axis->controlword & CONTROL_HALT) {
        return axis->halt_option == 2 ? RAMP_QUICK_STOP : RAMP_PROFILE;
      }
      return RAMP_NONE;
    case DRIVE_QUICK_STOP:
      return axis->quick_stop_option == 1 || axis->quick_stop_option == 5 ? RAMP_PROFILE
                                                                           : RAMP_QUICK_STOP;
    case DRIVE_REACTION:
      return axis->fault_option == 1 ? RAMP_PROFILE : RAMP_QUICK_STOP;
    default:
      return RAMP_NONE;
  }
}
