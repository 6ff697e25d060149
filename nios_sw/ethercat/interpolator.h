/* SPDX-License-Identifier: Apache-2.0 */
/* Targets of a slower master at the rate of the control, with continuous acceleration.
 *
 * Between two targets runs the quintic polynomial that has at both ends the value of the target and
 * the slope and bend of the parabola through it and its two neighbours. With p0..p3 the targets,
 * d0 = p1 - p0 and so on, j = d2 - 2 d1 + d0 and s = 0..1 from p1 to p2:
 *   p(s) = p1 + (d0 + d1)/2 s + (d1 - d0)/2 s^2 + j (-3/2 s^3 + 5/2 s^4 - s^5)
 * Value, slope and bend are continuous from piece to piece. A target is reached 2.5 periods after it
 * came: two for its neighbours, half a period to take up what the master's cycle jitters. A clock of
 * the master that runs away is followed by steps that are 1/512 longer or shorter. */
#ifndef ETHERCAT_INTERPOLATOR_H
#define ETHERCAT_INTERPOLATOR_H

#include <stdbool.h>
#include <stdint.h>

struct interpolator {
  int32_t p[4], next;
  uint32_t phase, span, step; /* span is one period, in 1/1024 of a control cycle */
  uint32_t period_us;         /* that span and per_span are of; 0 before the first start */
  float per_span;
  bool has_next, running;
  uint16_t missed; /* periods without a target */
};

struct interpolated {
  int32_t whole;
  float part;         /* added to whole, |part| < 1 */
  float slope, bend;  /* per period, per period^2 */
};

/* Rests at `value`, or goes on from it with `slope` (per period). */
void interpolator_start(struct interpolator *ip, int32_t value, int32_t slope, uint32_t period_us);
void interpolator_target(struct interpolator *ip, int32_t target);
/* The next control cycle. */
void interpolator_step(struct interpolator *ip, struct interpolated *out);

#endif
