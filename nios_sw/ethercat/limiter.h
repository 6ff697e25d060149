/* SPDX-License-Identifier: Apache-2.0 */
/* Limits of a cyclic set-point: speed (607F) and position (607D). A set-point that would leave them follows what is wanted
 * as fast as they allow, with the quick stop deceleration as its greatest acceleration, and comes to rest at a position
 * limit. Within the limits it is what is wanted, unchanged. */
#ifndef ETHERCAT_LIMITER_H
#define ETHERCAT_LIMITER_H

#include <stdbool.h>
#include <stdint.h>

#include "profile.h"

struct limits {
  float speed, deceleration; /* increments/s, increments/s2 */
  int32_t low, high;         /* positions of the master; those of int32_t: no limit */
  int32_t home;              /* of the master's positions over those of the set-point */
};

/* The set-point goes on towards `wanted`; `behind` is its state: it could not follow. Whether it was limited. */
bool limiter_follow(struct setpoint *point, const struct setpoint *wanted, const struct limits *limits, bool *behind);
/* The set-point goes on with this speed. */
bool limiter_run(struct setpoint *point, float velocity, float acceleration, const struct limits *limits);

#endif
