/* SPDX-License-Identifier: Apache-2.0 */
/* Interpolation of targets, see interpolator.h. */
#include "interpolator.h"

#include "gen/objects.h"

#define CYCLE 1024u

/* Differences of targets wrap as positions do. */
static int32_t minus(int32_t a, int32_t b) { return (int32_t)((uint32_t)a - (uint32_t)b); }
static int32_t plus(int32_t a, int32_t b) { return (int32_t)((uint32_t)a + (uint32_t)b); }

void interpolator_start(struct interpolator *ip, int32_t value, int32_t slope, uint32_t period_us) {
  if (ip->period_us != period_us) { /* a division of 64 bits is too long for every cycle of a stop */
    ip->period_us = period_us;
    ip->span = (uint32_t)(((uint64_t)period_us * CYCLE + CYCLE_US / 2u) / CYCLE_US);
    ip->per_span = 1.0f / (float)ip->span;
  }
  ip->p[1] = minus(value, (slope + (slope < 0)) >> 1); /* in the middle of the period it is at the value */
  ip->p[0] = minus(ip->p[1], slope);
  ip->p[2] = plus(ip->p[1], slope);
  ip->p[3] = plus(ip->p[2], slope);
  ip->step = CYCLE;
  ip->phase = ip->span / 2u;
  ip->has_next = false;
  ip->running = slope != 0;
  ip->missed = 0;
}

void interpolator_target(struct interpolator *ip, int32_t target) {
  int32_t late = (int32_t)(ip->phase - ip->span / 2u);
  ip->next = target;
  ip->has_next = true;
  ip->running = true;
  ip->step = CYCLE;
  if (late > (int32_t)(ip->span / 4u)) ip->step = CYCLE - CYCLE / 512u;
  if (late < -(int32_t)(ip->span / 4u)) ip->step = CYCLE + CYCLE / 512u;
}

static void shift(struct interpolator *ip) {
  int32_t slope = minus(ip->p[3], ip->p[2]);
  ip->p[0] = ip->p[1];
  ip->p[1] = ip->p[2];
  ip->p[2] = ip->p[3];
  if (ip->has_next) {
    ip->p[3] = ip->next;
    ip->has_next = false;
  } else {
    ip->p[3] = plus(ip->p[2], slope);
    if (ip->missed < 0xFFFFu) ++ip->missed;
  }
}

void interpolator_step(struct interpolator *ip, struct interpolated *out) {
  float d0, d1, d2, slope, bend, jump, s, offset, rate;
  int32_t whole;
  if (ip->running) {
    ip->phase += ip->step;
    if (ip->phase >= ip->span) {
      ip->phase -= ip->span;
      shift(ip);
    }
  }
  d0 = (float)minus(ip->p[1], ip->p[0]);
  d1 = (float)minus(ip->p[2], ip->p[1]);
  d2 = (float)minus(ip->p[3], ip->p[2]);
  slope = (d0 + d1) * 0.5f;
  bend = d1 - d0;
  jump = (d2 - d1) - bend;
  s = (float)(int32_t)ip->phase * ip->per_span;
  offset = s * (slope + s * (bend * 0.5f + s * jump * (-1.5f + s * (2.5f - s))));
  whole = (int32_t)offset;
  out->whole = plus(ip->p[1], whole);
  out->part = offset - (float)whole;
  rate = (float)(int32_t)ip->step * (1.0f / CYCLE);
  if (!ip->running) rate = 0.0f;
  out->slope = rate * (slope + s * (bend + s * jump * (-4.5f + s * (10.0f - 5.0f * s))));
  out->bend = rate * rate * (bend + s * jump * (-9.0f + s * (30.0f - 20.0f * s)));
}
