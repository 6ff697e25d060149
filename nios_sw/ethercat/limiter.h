/* SPDX-License-Identifier: Apache-2.0 */
/* Limits of a cyclic set-point: speed (607F) and position (607D). A set-point that would leave them follows what is wanted
 * as fast as they allow, with the quick stop deceleration as its greatest acceleration, and comes to rest at a position
 * limit. Within the limits it is what is wanted, unchanged. */
#ifndef ETHERCAT_LIMITER_H
#define ETHERCAT_LIMITER_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "cycle.h"
#include "profile.h"

struct limits {
  float speed, deceleration; /* increments/s, increments/s2 */
  int32_t low, high;         /* positions of the master; those of int32_t: no limit */
  int32_t home;              /* of the master's positions over those of the set-point */
};

#define LIMITER_NEAR 1.004f /* of the speed limit: following the master's clock makes steps 1/512 longer */

/* Whether a set-point may go on by this step; near: limiter_near of the greatest speed. */
static inline float limiter_near(float speed) { return speed * LIMITER_NEAR + 1.0f; }
static inline bool limiter_allows(float step, float near) { return !(fabsf(step) * CYCLES_PER_S > near); }
/* Whether there are position limits. */
static inline bool limiter_bounds(int32_t low, int32_t high) { return low != INT32_MIN || high != INT32_MAX; }
/* From one set-point to the next, increments. */
static inline float limiter_step(const struct setpoint *from, const struct setpoint *to) {
  return (float)(int32_t)((uint32_t)to->whole - (uint32_t)from->whole) + (to->part - from->part);
}

/* The set-point goes on towards `wanted`; `behind` is its state: it could not follow. Whether it was limited. */
bool limiter_follow(struct setpoint *point, const struct setpoint *wanted, const struct limits *limits, bool *behind);
/* The set-point goes on with this speed. */
bool limiter_run(struct setpoint *point, float velocity, float acceleration, const struct limits *limits);

#endif
