/* SPDX-License-Identifier: Apache-2.0 */
/* Limits of a cyclic set-point, see limiter.h. */
#include "limiter.h"

#include <math.h>

static bool bounded(const struct limits *limits) { return limiter_bounds(limits->low, limits->high); }

/* a - b; what is beyond an int32_t is far enough away. */
static float difference(int32_t a, int32_t b) {
  uint32_t size = a >= b ? (uint32_t)a - (uint32_t)b : (uint32_t)b - (uint32_t)a;
  float way = (float)(int32_t)(size > INT32_MAX ? INT32_MAX : size);
  return a >= b ? way : -way;
}

/* Increments from the set-point to the limit in a direction (its sign), below 0 beyond it. */
static float left(const struct setpoint *point, const struct limits *limits, float direction) {
  int32_t place = (int32_t)((uint32_t)point->whole + (uint32_t)limits->home);
  if (direction > 0.0f) return difference(limits->high, place) - point->part;
  return difference(place, limits->low) + point->part;
}

/* The greatest speed after the next cycle from which the deceleration stops within `way`, which is without what the
 * speed of now moves in half of that cycle. */
static float stoppable(float way, float deceleration) {
  float half = 0.5f * deceleration * CYCLE_S;
  return way > 0.0f ? sqrtf(2.0f * deceleration * way + half * half) - half : 0.0f;
}

static float greatest(const struct setpoint *point, const struct limits *limits, float direction) {
  float sign = direction < 0.0f ? -1.0f : 1.0f, near;
  if (!bounded(limits)) return limits->speed;
  near = stoppable(left(point, limits, direction) - sign * point->velocity * (0.5f * CYCLE_S), limits->deceleration);
  return near < limits->speed ? near : limits->speed;
}

/* Whether the set-point may be at `wanted` in the next cycle, by a step this long. */
static bool allowed(const struct setpoint *wanted, float step, const struct limits *limits) {
  float way, speed = step < 0.0f ? -wanted->velocity : wanted->velocity;
  if (!limiter_allows(step, limiter_near(limits->speed))) return false;
  if (!bounded(limits) || step == 0.0f) return true;
  way = left(wanted, limits, step);
  return way >= 0.0f && (speed <= 0.0f || speed * speed <= 2.0f * limits->deceleration * way);
}

/* A cycle on, from the speed of the set-point to this one, but to rest at a limit that it would cross. */
static void go(struct setpoint *point, float velocity, const struct limits *limits) {
  float before = point->velocity, way = (before + velocity) * (0.5f * CYCLE_S);
  bool inside = bounded(limits) && way != 0.0f && left(point, limits, way) >= 0.0f;
  point->velocity = velocity;
  point->acceleration = (velocity - before) * CYCLES_PER_S;
  setpoint_advance(point, way);
  if (!inside || left(point, limits, way) >= 0.0f) return;
  *point = (struct setpoint){.whole = (int32_t)((uint32_t)(way > 0.0f ? limits->high : limits->low) -
                                                (uint32_t)limits->home)};
}

bool limiter_follow(struct setpoint *point, const struct setpoint *wanted, const struct limits *limits,
                    bool *behind) {
  float step = limiter_step(point, wanted);
  float sign = step < 0.0f ? -1.0f : 1.0f, change = limits->deceleration * CYCLE_S;
  float before, away, most, velocity;
  bool fits = allowed(wanted, step, limits);
  if (fits && !*behind) {
    *point = *wanted;
    return false;
  }
  /* Towards it, so that its speed is met where it is. */
  before = sign * point->velocity;
  away = sign * step - (before + sign * wanted->velocity) * (0.5f * CYCLE_S);
  velocity = stoppable(away, limits->deceleration) + sign * wanted->velocity;
  most = greatest(point, limits, sign);
  if (velocity > most) velocity = most;
  if (velocity > before + change) velocity = before + change;
  if (velocity < before - change) velocity = before - change;
  away = sign * step - (before + velocity) * (0.5f * CYCLE_S);
  velocity *= sign;
  *behind = !fits || fabsf(velocity - wanted->velocity) > 2.0f * change || fabsf(away) > change * CYCLE_S;
  if (*behind) {
    go(point, velocity, limits);
  } else {
    *point = *wanted;
  }
  return true;
}

bool limiter_run(struct setpoint *point, float velocity, float acceleration, const struct limits *limits) {
  float most = greatest(point, limits, velocity);
  bool limited = fabsf(velocity) > most;
  if (limited) velocity = velocity < 0.0f ? -most : most;
  go(point, velocity, limits);
  if (!limited && point->velocity == velocity) point->acceleration = acceleration;
  return limited;
}
