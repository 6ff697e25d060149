/* SPDX-License-Identifier: Apache-2.0 */
/* The tracking law of the five-axis robot. Axes 0-2 are the legs 1-3, axis 3 the tilt, axis 4 the
 * rotation; m and N for legs, rad and N m for the table. */
#ifndef NIOS_TRACKING_H
#define NIOS_TRACKING_H

#include <stdint.h>

#include "gen/parameters.h"
#include "gen/system.h"
#include "gen/tick.h"

#define AXES 5
#define LEGS 3

/* What the law keeps from tick to tick. */
struct axis_state {
  float position;  /* l(t-1), theta(t-1) */
  float sign;      /* s_g(t-1) */
  float ticks;     /* t_c / T_s */
  float s_c;       /* integrator */
};

/* Desired joint motion of the last tick, table 3. */
struct joint_motion {
  float position[LEGS], velocity[LEGS], acceleration[LEGS];
};

/* The robot: zero in the image, written by the host before the program starts. */
extern struct tracking_parameters tracking_parameters;
extern struct axis_state tracking_state[AXES];
extern struct joint_motion tracking_desired;

/* Takes the present counts as the last ones; empties the integrators. */
void tracking_start(const volatile struct tick_input *in);

/* One tick. Both pointers may be I/O: each word is accessed once. */
void tracking_tick(const volatile struct tick_input *in, volatile struct tick_output *out);

#endif
