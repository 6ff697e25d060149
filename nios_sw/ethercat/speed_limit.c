/* SPDX-License-Identifier: Apache-2.0 */
/* Speed limit of the torque modes, see speed_limit.h. */
#include "speed_limit.h"

#include "cycle.h"

#define FILTER 0.0625f /* lags by 15 cycles while the speed changes steadily */
/* Cycles from the middle of the last difference of positions to the tick at which the law has the set-point, and the lag
 * of the first filter, as a share of the lag of the second one. */
#define AHEAD (16.5f / 15.0f)
#define HEADROOM 100.0f /* 0.1 %: the law's first torques are noisy; with this start of their mean they do not end the hold */
/* Shares of the limit. After the law gave the axis back, it may hold it again below the first one or above the second one. */
#define BELOW 0.9375f
#define ABOVE 1.03125f

void speed_limit_start(struct speed_limit *limit, float velocity) {
  *limit = (struct speed_limit){.slower = velocity, .sign = 1.0f};
}

/* The law holds the speed until it needs more torque than is asked for, or the limit rises. */
static bool goes_on(struct speed_limit *limit, const struct setpoint *point, const struct axis_feedback *feedback,
                    const struct torque_wanted *wanted) {
  limit->needs += ((float)feedback->torque - limit->needs) * FILTER;
  if (limit->sign * point->velocity < wanted->most) return false;
  limit->free = limit->sign * (wanted->torque - limit->needs) < 0.0f;
  return !limit->free;
}

static bool begins(struct speed_limit *limit, float speed, const struct torque_wanted *wanted) {
  float sign = speed < 0.0f ? -1.0f : 1.0f, size = sign * speed;
  if (sign != limit->sign || size < BELOW * wanted->most || size > ABOVE * wanted->most) limit->free = false;
  if (size < wanted->most || (limit->free && sign * (wanted->torque - limit->needs) <= 0.0f)) return false;
  limit->sign = sign;
  limit->needs = wanted->torque - sign * HEADROOM;
  limit->free = false;
  return true;
}

bool speed_limit_cycle(struct speed_limit *limit, struct setpoint *point, const struct axis_feedback *feedback,
                       const struct torque_wanted *wanted) {
  float speed;
  limit->slower += (wanted->velocity - limit->slower) * FILTER;
  if (limit->holds) {
    limit->holds = goes_on(limit, point, feedback, wanted);
    if (limit->holds) setpoint_run(point, limit->sign * wanted->most, wanted->deceleration, CYCLE_S);
    return limit->holds;
  }
  speed = wanted->velocity + AHEAD * (wanted->velocity - limit->slower);
  limit->holds = begins(limit, speed, wanted);
  if (!limit->holds) return false;
  /* The prediction is above the speed of an axis that gains speed; the filtered speed is not. */
  speed = limit->sign * wanted->velocity > wanted->most ? wanted->velocity : limit->sign * wanted->most;
  *point = (struct setpoint){.whole = feedback->position, .velocity = speed};
  setpoint_advance(point, speed * CYCLE_S);
  return true;
}
