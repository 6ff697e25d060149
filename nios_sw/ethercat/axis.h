/* SPDX-License-Identifier: Apache-2.0 */
/* One axis: modes of operation, set-points, supervision. Axes count from 0. */
#ifndef ETHERCAT_AXIS_H
#define ETHERCAT_AXIS_H

#include <stdbool.h>
#include <stdint.h>

#include "application.h"

#define MODE_PROFILE_POSITION 1
#define MODE_PROFILE_VELOCITY 3
#define MODE_PROFILE_TORQUE 4
#define MODE_HOMING 6
#define MODE_CSP 8
#define MODE_CSV 9
#define MODE_CST 10

void axis_start(int n);
/* One control cycle of all axes; fresh: new outputs of the master have come. */
void axis_cycles(const struct feedback *feedback, bool fresh, struct command *command);
void axis_enter_op(int n);
/* OP is left: with an error code the axis faults, without it stops quickly. */
void axis_leave_op(int n, uint16_t error);
void axis_fault(int n, uint16_t error);
/* Cycle of the master by object 60C2, or by SYNC0 if that is less than 1 us from it. */
uint32_t axis_period_100ns(int n);
/* 0, or the abort code of a value that its object refuses because of another value, or that asks for what is not there: 607D, 60B8,
 * 60C2, 60D0. */
uint32_t axis_check(uint16_t index, uint8_t subindex, uint32_t value);

#endif
