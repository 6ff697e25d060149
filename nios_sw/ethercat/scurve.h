/* SPDX-License-Identifier: Apache-2.0 */
/* Jerk-limited move from any speed and acceleration to a stop, in the least time: a change of speed to
 * the peak, a cruise, a change of speed to 0. The peak speed is found by bisection, a step at each call, so
 * that no control cycle gets long. Units: increments and seconds. */
#ifndef ETHERCAT_SCURVE_H
#define ETHERCAT_SCURVE_H

#include <stdbool.h>
#include <stdint.h>

#define SCURVE_PHASES 7
#define SCURVE_STEPS 32 /* of a plan: both ends, 28 halvings, durations, states */

struct scurve_limits {
  float velocity, acceleration, deceleration, jerk;
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
  uint8_t step; /* the next one */
};

/* From (0, v, a) to another speed, and that speed from then on: `move` is complete at once, its states give no
 * place of use. */
void scurve_change(struct scurve *move, float v, float a, float target, const struct scurve_limits *limits);
/* From (0, v, a) over `length`. */
void scurve_begin(struct scurve_plan *plan, float length, float v, float a,
                  const struct scurve_limits *limits);
/* The next step; after SCURVE_STEPS of them `move` is complete. */
void scurve_search(struct scurve_plan *plan, struct scurve *move);
/* The state that scurve_next will give after so many calls; false after the end. */
bool scurve_ahead(const struct scurve *move, uint32_t cycles, float cycle, struct scurve_state *state);
/* The state one control cycle on (`cycle` seconds); false after the end. */
bool scurve_next(struct scurve *move, float cycle, struct scurve_state *state);

#endif
