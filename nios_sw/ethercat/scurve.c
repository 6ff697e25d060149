/* SPDX-License-Identifier: Apache-2.0 */
/* Jerk-limited move, see scurve.h. */
#include "scurve.h"

#include <math.h>

static struct scurve_state after(const struct scurve_state *s, float jerk, float t) {
  struct scurve_state end;
  end.x = s->x + t * (s->v + t * (s->a * 0.5f + t * jerk * (1.0f / 6.0f)));
  end.v = s->v + t * (s->a + t * jerk * 0.5f);
  end.a = s->a + t * jerk;
  return end;
}

/* The greatest acceleration of a change of speed with this sign: the lesser one of both when it goes through 0. */
static float most_of(float from, float to, float sign, const struct scurve_limits *limits) {
  bool faster = sign * (from + to) >= 0.0f;
  if (from * to < 0.0f) faster = limits->acceleration < limits->deceleration;
  return faster ? limits->acceleration : limits->deceleration;
}

/* From `from` to speed v with acceleration 0 in the least time: durations and jerks of three phases, and
 * the state at the end. */
static struct scurve_state change_speed(const struct scurve_state *from, float v,
                                        const struct scurve_limits *limits, float *duration,
                                        float *jerk) {
  float j = limits->jerk, most;
  float sign = v >= from->v + from->a * fabsf(from->a) / (2.0f * j) ? 1.0f : -1.0f;
  float a = sign * from->a, change = sign * (v - from->v);
  float square = j * change + a * a * 0.5f, peak;
  struct scurve_state s = *from;
  most = most_of(from->v, v, sign, limits);
  if (a > most) most = a; /* limits were lowered in motion */
  peak = square > 0.0f ? sqrtf(square) : 0.0f;
  duration[1] = 0.0f;
  if (peak > most) {
    peak = most;
    duration[1] = (change - (most * most - a * a * 0.5f) / j) / most;
    if (duration[1] < 0.0f) duration[1] = 0.0f;
  }
  duration[0] = (peak - a) / j;
  if (duration[0] < 0.0f) duration[0] = 0.0f;
  duration[2] = peak / j;
  jerk[0] = sign * j;
  jerk[1] = 0.0f;
  jerk[2] = -sign * j;
  for (int i = 0; i < 3; ++i) s = after(&s, jerk[i], duration[i]);
  s.v = v;
  s.a = 0.0f;
  return s;
}

/* Length of the move with this peak speed and no cruise. */
static float length_with(const struct scurve_plan *plan, float peak) {
  float duration[3], jerk[3];
  struct scurve_state s = change_speed(&plan->start, peak, &plan->limits, duration, jerk);
  return change_speed(&s, 0.0f, &plan->limits, duration, jerk).x;
}

void scurve_begin(struct scurve_plan *plan, float length, float v, float a,
                  const struct scurve_limits *limits) {
  plan->limits = *limits;
  plan->start = (struct scurve_state){0.0f, v, a};
  plan->length = length;
  plan->low = -limits->velocity;
  plan->high = limits->velocity;
  plan->step = 0;
}

/* The peak is taken on the side of less speed, so that a cruise closes the gap that is left. */
static float peak_of(const struct scurve_plan *plan) { return plan->high > 0.0f ? plan->low : plan->high; }

static void find_durations(const struct scurve_plan *plan, struct scurve *move) {
  float peak = peak_of(plan), gap;
  struct scurve_state s = change_speed(&plan->start, peak, &plan->limits, move->duration, move->jerk);
  gap = plan->length - change_speed(&s, 0.0f, &plan->limits, move->duration + 4, move->jerk + 4).x;
  move->duration[3] = gap * peak > 0.0f ? gap / peak : 0.0f;
  move->jerk[3] = 0.0f;
}

static void find_states(const struct scurve_state *start, float peak, struct scurve *move) {
  struct scurve_state s = *start;
  for (int i = 0; i < SCURVE_PHASES; ++i) {
    move->at[i] = s;
    s = after(&s, move->jerk[i], move->duration[i]);
    if (i == 2 || i == 3) s.a = 0.0f, s.v = peak;
  }
  move->phase = 0;
  move->cycle = 0;
  move->late = 0.0f;
}

void scurve_change(struct scurve *move, float v, float a, float target, const struct scurve_limits *limits) {
  struct scurve_state start = {0.0f, v, a};
  change_speed(&start, target, limits, move->duration, move->jerk);
  for (int i = 3; i < SCURVE_PHASES; ++i) move->duration[i] = move->jerk[i] = 0.0f;
  find_states(&start, target, move);
}

void scurve_search(struct scurve_plan *plan, struct scurve *move) {
  float middle = (plan->low + plan->high) * 0.5f;
  uint8_t step = plan->step++;
  if (step == 0) {
    if (length_with(plan, plan->high) <= plan->length) plan->low = plan->high;
  } else if (step == 1) {
    if (length_with(plan, plan->low) >= plan->length) plan->high = plan->low;
  } else if (step < SCURVE_STEPS - 2) {
    if (length_with(plan, middle) <= plan->length) {
      plan->low = middle;
    } else {
      plan->high = middle;
    }
  } else if (step == SCURVE_STEPS - 2) {
    find_durations(plan, move);
  } else {
    find_states(&plan->start, peak_of(plan), move);
  }
}

bool scurve_ahead(const struct scurve *move, uint32_t cycles, float cycle, struct scurve_state *state) {
  struct scurve then = *move;
  then.cycle += cycles - 1u;
  return scurve_next(&then, cycle, state);
}

bool scurve_next(struct scurve *move, float cycle, struct scurve_state *state) {
  float t;
  ++move->cycle;
  t = (float)move->cycle * cycle - move->late;
  while (move->phase < SCURVE_PHASES && t > move->duration[move->phase]) {
    t -= move->duration[move->phase++];
    move->late = cycle - t;
    move->cycle = 1;
  }
  if (move->phase == SCURVE_PHASES) return false;
  *state = after(&move->at[move->phase], move->jerk[move->phase], t);
  return true;
}
