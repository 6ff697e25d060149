/* SPDX-License-Identifier: Apache-2.0 */
/* The application of the slave controller: five axes, digital I/O, and what ties them to the bus. No
 * operating system: application_cycle every CYCLE_100NS, application_background as often as there is time. */
#ifndef ETHERCAT_APPLICATION_H
#define ETHERCAT_APPLICATION_H

#include <stdbool.h>
#include <stdint.h>

#include "gen/objects.h"

extern struct objects objects;

#define PROBES 2 /* touch probes: inputs 1 and 2 */

/* Of the machine, each cycle. Positions in increments since power on. */
struct axis_feedback {
  int32_t position;
  int16_t torque; /* 0.1 % of the rated one */
  uint16_t fault; /* error code of CiA 402, 0: none */
  int32_t index_position; /* of the encoder, at the last pulse of its index */
  uint16_t index_count;   /* of these pulses, modulo 64 */
  uint16_t switches;      /* SWITCH_* */
};
#define SWITCH_NEGATIVE 0x01u /* limit switches, as in 60FD */
#define SWITCH_POSITIVE 0x02u
#define SWITCH_HOME 0x04u
struct feedback {
  struct axis_feedback axis[AXES];
  float pose[AXES]; /* of the tool */
  uint8_t digital_inputs;
  uint16_t edge_age[PROBES]; /* from the last edge of inputs 1 and 2 to the tick, 1/65536 of a control cycle */
};

/* To the law. Without power it gives no torque. */
struct axis_command {
  int32_t position;     /* increments */
  float fraction;       /* of an increment, added to the position */
  float velocity;       /* increments/s */
  float acceleration;   /* increments/s2 */
  int16_t torque;       /* 0.1 %: feed-forward, or all of it with torque_only */
  bool power, torque_only;
};
struct command {
  struct axis_command axis[AXES];
  uint8_t digital_outputs;
  /* A changed setting of the law: number of the change, 0 before the first; object, subindex, value. */
  uint32_t setting_number;
  uint16_t setting_index;
  uint8_t setting_subindex;
  float setting_value;
};

void application_start(void);
void application_cycle(const struct feedback *feedback, struct command *command);
void application_background(void);

/* From the other parts of the application. */
void application_written(uint16_t index, uint8_t subindex); /* an object, by SDO */
void application_enter_op(void);
void application_leave_op(bool fault);
void application_inputs(void); /* process data to the master */
uint32_t application_sync0_ns(void); /* cycle of the SYNC0 that 1C32:01 = 2 asks for, otherwise 0 */
void application_errors(void); /* the error register, from the errors of the axes */

#endif
