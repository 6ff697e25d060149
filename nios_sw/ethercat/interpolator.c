/* SPDX-License-Identifier: Apache-2.0 */
/* Interpolation of targets, see interpolator.h. */
#include "interpolator.h"

#include "cycle.h"

#define CYCLE 1024u
#define SLOWER (CYCLE - CYCLE / 512u)
#define FASTER (CYCLE + CYCLE / 512u)
#define RATE(step) ((float)(step) / (float)CYCLE)

struct interpolator_place interpolator_place;

/* Differences of targets wrap as positions do. */
static int32_t minus(int32_t a, int32_t b) { return (int32_t)((uint32_t)a - (uint32_t)b); }
static int32_t plus(int32_t a, int32_t b) { return (int32_t)((uint32_t)a + (uint32_t)b); }

void interpolator_start(struct interpolator *ip, int32_t value, int32_t slope, uint32_t period_100ns) {
  if (ip->period_100ns != period_100ns) { /* a division of 64 bits is too long for every cycle of a stop */
    ip->period_100ns = period_100ns;
    ip->span = (uint32_t)(((uint64_t)period_100ns * CYCLE + CYCLE_100NS / 2u) / CYCLE_100NS);
    ip->per_span = 1.0f / (float)ip->span;
    ip->per_s = ip->per_span * ((float)CYCLE * CYCLES_PER_S);
  }
  ip->p1 = minus(value, (slope + (slope < 0)) >> 1); /* in the middle of the period it is at the value */
  ip->p2 = plus(ip->p1, slope);
  ip->p3 = plus(ip->p2, slope);
  ip->step = CYCLE;
  ip->rate = ip->rate_2 = slope ? 1.0f : 0.0f;
  ip->way = ip->ahead = ip->slope = (float)slope;
  ip->bend = ip->half_bend = ip->curve = ip->jump = 0.0f;
  ip->phase = ip->span / 2u;
  ip->has_next = false;
  ip->running = slope != 0;
  ip->trend = slope;
  ip->lost = 0;
}

void interpolator_target(struct interpolator *ip, int32_t target) {
  int32_t late = (int32_t)(ip->phase - ip->span / 2u);
  ip->next = target;
  ip->has_next = true;
  ip->running = true;
  ip->step = CYCLE;
  ip->rate = ip->rate_2 = 1.0f;
  if (late > (int32_t)(ip->span / 4u)) {
    ip->step = SLOWER;
    ip->rate = RATE(SLOWER);
    ip->rate_2 = RATE(SLOWER) * RATE(SLOWER);
  } else if (late < -(int32_t)(ip->span / 4u)) {
    ip->step = FASTER;
    ip->rate = RATE(FASTER);
    ip->rate_2 = RATE(FASTER) * RATE(FASTER);
  }
}

/* The next piece. Its d0 and d1 are d1 and d2 of the one before. */
void interpolator_shift(struct interpolator *ip) {
  int32_t slope = ip->trend;
  float before = ip->way;
  ip->phase -= ip->span;
  ip->p1 = ip->p2;
  ip->p2 = ip->p3;
  if (ip->has_next) {
    slope = minus(ip->next, ip->p3);
    /* Without lost ones the trend is the slope. */
    ip->trend = ip->lost ? plus(ip->trend, minus(slope, ip->trend) / (ip->lost + 1)) : slope;
    ip->lost = 0;
    ip->has_next = false;
  } else if (ip->lost < 0xFFFFu) {
    ++ip->lost;
  }
  ip->p3 = plus(ip->p3, slope);
  ip->way = ip->ahead;
  ip->ahead = (float)slope;
  ip->slope = (before + ip->way) * 0.5f;
  ip->bend = ip->curve;
  ip->half_bend = ip->bend * 0.5f;
  ip->curve = ip->ahead - ip->way;
  ip->jump = ip->curve - ip->bend;
}

void interpolator_move(uint32_t phase, float per_span) {
  struct interpolator_place *at = &interpolator_place;
  float s = (float)(int32_t)phase * per_span;
  at->phase = phase;
  at->per_span = per_span;
  at->s = s;
  at->value = -1.5f + s * (2.5f - s);
  at->slope = -4.5f + s * (10.0f - 5.0f * s);
  at->bend = -9.0f + s * (30.0f - 20.0f * s);
}
