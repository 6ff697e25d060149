/* SPDX-License-Identifier: Apache-2.0 */
/* Jerk-limited move from any speed and acceleration to a stop, in the least time: a change of speed to
 * the peak, a cruise, a change of speed to 0. The peak speed is found by bisection, a few steps at each
 * call, so that no control cycle gets long. Units: increments and seconds. */
#ifndef ETHERCAT_SCURVE_H
#define ETHERCAT_SCURVE_H

#include <stdbool.h>
#include <stdint.h>

#define SCURVE_PHASES 7
#define SCURVE_STEPS 32 /* of the bisection in all */

struct scurve_limits {
  float velocity, acceleration, jerk;
};

struct scurve_state {
  float x, v, a;
};

/* Phases of constant jerk and the state at the begin of each. */
struct scurve {
  float duration[SCURVE_PHASES], jerk[SCURVE_PHASES];
  struct scurve_state at[SCURVE_PHASES];
  uint8_t phase;
  uint32_t cycle; /* in the phase */
  float late;     /* of the phase's begin after a control cycle, s */
};

struct scurve_plan {
  struct scurve_limits limits;
  struct scurve_state start;
  float length, low, high, peak;
  uint8_t steps; /* left */
};

/* From (0, v, a) over `length`. */
void scurve_begin(struct scurve_plan *plan, float length, float v, float a,
                  const struct scurve_limits *limits);
/* Some steps; whether that was all. */
bool scurve_search(struct scurve_plan *plan, uint8_t steps);
void scurve_finish(const struct scurve_plan *plan, struct scurve *move);
/* The state one control cycle on (`cycle` seconds); false behind the end. */
bool scurve_next(struct scurve *move, float cycle, struct scurve_state *state);

#endif
