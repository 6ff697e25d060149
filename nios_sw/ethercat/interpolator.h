/* SPDX-License-Identifier: Apache-2.0 */
/* Targets of a slower master at the rate of the control, with continuous acceleration.
 *
 * Between two targets runs the quintic polynomial that has at both ends the value of the target and
 * the slope and bend of the parabola through it and its two neighbours. With p0..p3 the targets,
 * d0 = p1 - p0 and so on, j = d2 - 2 d1 + d0 and s = 0..1 from p1 to p2:
 *   p(s) = p1 + (d0 + d1)/2 s + (d1 - d0)/2 s^2 + j (-3/2 s^3 + 5/2 s^4 - s^5)
 * Value, slope and bend are continuous from piece to piece. A target is reached 2.5 periods after it
 * came: two for its neighbours, half a period to take up what the master's cycle jitters. A lost target
 * is extrapolated from the last two that came, so that the error of one is not the slope of the next. A
 * clock of the master that runs away is followed by steps that are 1/512 longer or shorter. */
#ifndef ETHERCAT_INTERPOLATOR_H
#define ETHERCAT_INTERPOLATOR_H

#include <stdbool.h>
#include <stdint.h>

struct interpolator {
  int32_t p1, p2, p3, next;   /* places of targets: between the first two is the set-point */
  uint32_t phase, span, step; /* span is one period, in 1/1024 of a control cycle */
  uint32_t period_100ns;      /* that span and per_span are of; 0 before the first start */
  float per_span, per_s;      /* 1 / span, periods in a second */
  float rate, rate_2;         /* of the phase, control cycles in one, 0 at rest; its square */
  /* Of the piece from p1 to p2: d1, d2, and what the polynomial is made of, so that only a new piece is converted. */
  float way, ahead;
  float slope, bend, half_bend, curve, jump; /* curve: the bend of the piece to come */
  bool has_next, running;
  int32_t trend; /* the way per period between the last two targets that came */
  uint16_t lost; /* periods since the last one */
};

/* What depends on the place within a piece alone. Axes whose targets come together share it. */
struct interpolator_place {
  uint32_t phase;
  float per_span;
  float s, value, slope, bend; /* the factors of j in p and its derivatives, without s, s, 1 */
};
extern struct interpolator_place interpolator_place;

struct interpolated {
  int32_t whole;
  float part;         /* added to whole, |part| < 1 */
  float slope, bend;  /* per period, per period^2 */
};

/* Rests at `value`, or goes on from it with `slope` (per period). */
void interpolator_start(struct interpolator *ip, int32_t value, int32_t slope, uint32_t period_100ns);
void interpolator_target(struct interpolator *ip, int32_t target);
/* The parts of interpolator_step that most control cycles do without. */
void interpolator_shift(struct interpolator *ip);
void interpolator_move(uint32_t phase, float per_span);

/* The next control cycle. */
static inline void interpolator_step(struct interpolator *ip, struct interpolated *out) {
  const struct interpolator_place *at = &interpolator_place;
  float s, lean, offset, rate = ip->rate;
  int32_t whole;
  if (ip->running) {
    ip->phase += ip->step;
    if (ip->phase >= ip->span) interpolator_shift(ip);
  }
  if (ip->phase != at->phase || ip->per_span != at->per_span) interpolator_move(ip->phase, ip->per_span);
  s = at->s;
  lean = s * ip->jump;
  offset = s * (ip->slope + s * (ip->half_bend + lean * at->value));
  whole = (int32_t)offset;
  out->slope = rate * (ip->slope + s * (ip->bend + lean * at->slope));
  out->bend = ip->rate_2 * (ip->bend + lean * at->bend);
  out->whole = (int32_t)((uint32_t)ip->p1 + (uint32_t)whole);
  out->part = offset - (float)whole;
}

#endif
