/* SPDX-License-Identifier: Apache-2.0 */
/* Words of a control tick of the device on the bus, in the blocks input and output of the Nios II system. */
#ifndef ETHERCAT_TICK_H
#define ETHERCAT_TICK_H

#include <stdint.h>

#include "gen/objects.h"

struct ethercat_input {
  int32_t position[AXES];      /* increments */
  int32_t torque_fault[AXES];  /* bits 15:0 torque in 0.1 %, 31:16 error code of CiA 402 */
  float pose[AXES];            /* of the tool, m and rad */
  uint32_t digital_inputs;     /* bits 7:0, and the switches of axis n (SWITCH_*) from bit TICK_SWITCHES + 3 n on */
  uint32_t index_counts;       /* pulses of the index of axis n since power on, modulo 64, in bits 6 n + 5 : 6 n */
  int32_t index_position[AXES]; /* increments, at the last of these pulses */
  uint32_t edge_ages;          /* from the last edge to the tick, 1/65536 of it: input 1 bits 15:0, 2 bits 31:16 */
};

#define TICK_SWITCHES 8

#define TICK_POWER 0x10000u
#define TICK_TORQUE_ONLY 0x20000u

struct ethercat_output {
  int32_t position[AXES];      /* increments, and a part of one */
  float fraction[AXES];
  float velocity[AXES];        /* increments/s */
  float acceleration[AXES];    /* increments/s2 */
  uint32_t torque_flags[AXES]; /* bits 15:0 torque in 0.1 %, TICK_POWER, TICK_TORQUE_ONLY */
  uint32_t digital_outputs;
  /* A changed gain of the law: rises with each, object << 8 | subindex, its value. */
  uint32_t setting_number, setting_place;
  float setting_value;
};

#endif
