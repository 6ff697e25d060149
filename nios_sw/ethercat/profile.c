/* SPDX-License-Identifier: Apache-2.0 */
/* Profile position and profile velocity, see profile.h. A move is planned while the one before still runs: it begins
 * PLAN_CYCLES later, from where that one will be then. One axis plans at a time, a step in each control
 * cycle, so that no pass gets long; the others wait. */
#include "profile.h"

#include <math.h>

#include "cycle.h"
#include "limiter.h"

#define PLAN_CYCLES (SCURVE_STEPS + 2) /* to begin, steps, to change over */
#define LEAST_CHANGE (1.0f / (1 << 23))
#define NEW_TARGET 0x10u
#define AT_ONCE 0x20u
#define RELATIVE 0x40u

static const struct profile *planner; /* who plans, or did until its next cycle */

void setpoint_advance(struct setpoint *point, float way) {
  float sum = point->part + way;
  int32_t whole = saturated(sum);
  point->whole = (int32_t)((uint32_t)point->whole + (uint32_t)whole);
  point->part = sum - (float)whole;
}

void setpoint_run(struct setpoint *point, float velocity, float acceleration, float cycle) {
  float step = acceleration * cycle, before = point->velocity, change = velocity - before;
  float least = fabsf(before) * LEAST_CHANGE; /* of a float, so that every ramp ends */
  if (step < least) step = least;
  if (fabsf(change) <= step) {
    point->velocity = velocity;
  } else {
    point->velocity = change < 0.0f ? before - step : before + step;
  }
  point->acceleration = (point->velocity - before) / cycle;
  setpoint_advance(point, (before + point->velocity) * (0.5f * cycle));
}

void setpoint_brake(struct setpoint *point, float deceleration, float cycle) {
  setpoint_run(point, 0.0f, deceleration, cycle);
}

void profile_start(struct profile *profile) {
  if (planner == profile) planner = 0;
  profile->planning = 0;
  profile->moving = profile->has_next = profile->acknowledged = false;
  profile->reached = true;
  profile->within = 0;
  profile->planned_speed = profile->blocked = false;
  profile->faster = 0;
}

void profile_drop(struct profile *profile) {
  if (planner != profile) return;
  planner = 0;
  profile->planning = 0;
}

int32_t profile_wanted(const struct profile *profile, const struct axis_objects *o, int32_t home) {
  uint32_t from = (uint32_t)o->position_demand;
  if (!(o->controlword & RELATIVE)) return o->target_position;
  if (profile->moving) from = (uint32_t)profile->goal + (uint32_t)home;
  if (profile->planning) from = (uint32_t)profile->plan_goal + (uint32_t)home;
  return (int32_t)(from + (uint32_t)o->target_position);
}

void profile_target(struct profile *profile, const struct axis_objects *o, int32_t target, int32_t home, float most) {
  float speed = (float)o->profile_velocity;
  if (profile->has_next && !(o->controlword & AT_ONCE)) return; /* one waits already: not acknowledged */
  profile->next = (int32_t)((uint32_t)target - (uint32_t)home);
  profile->has_next = true;
  profile->at_once = o->controlword & AT_ONCE;
  profile->limits.velocity = speed < most ? speed : most;
  profile->limits.acceleration = (float)o->profile_acceleration;
  profile->limits.deceleration = (float)o->profile_deceleration;
  profile->limits.jerk = (float)o->profile_jerk * 1000.0f;
  profile->acknowledged = true;
  profile->reached = false;
}

/* Where the set-point will be when the planned move begins. */
static void begin_plan(struct profile *profile, const struct setpoint *point) {
  struct scurve_state state = {0.0f, 0.0f, 0.0f};
  struct setpoint then = *point;
  if (profile->moving) {
    bool on = scurve_ahead(&profile->move, PLAN_CYCLES, CYCLE_S, &state);
    then.whole = on ? profile->origin : profile->goal;
    then.part = on ? profile->origin_part : 0.0f;
    if (!on) state = (struct scurve_state){0.0f, 0.0f, 0.0f};
    setpoint_advance(&then, state.x);
  }
  profile->plan_origin = then.whole;
  profile->plan_origin_part = then.part;
  profile->has_next = false;
  profile->plan_goal = profile->next;
  profile->planning = PLAN_CYCLES - 1;
  planner = profile;
  scurve_begin(&profile->plan,
               (float)(int32_t)((uint32_t)profile->next - (uint32_t)then.whole) - then.part, state.v,
               state.a, &profile->limits);
}

void profile_cycle(struct profile *profile, const struct axis_objects *o, struct setpoint *point) {
  struct scurve_state state;
  bool others = planner == profile && !profile->planning; /* their turn */
  if (others) planner = 0;
  if (!(o->controlword & NEW_TARGET) && !profile->has_next) profile->acknowledged = false;
  if (!profile->moving && point->velocity != 0.0f) {
    setpoint_brake(point, (float)o->profile_deceleration, CYCLE_S);
    return;
  }
  if (profile->planning) {
    if (--profile->planning) {
      scurve_search(&profile->plan, &profile->planned);
    } else {
      profile->move = profile->planned;
      profile->origin = profile->plan_origin;
      profile->origin_part = profile->plan_origin_part;
      profile->goal = profile->plan_goal;
      profile->moving = true;
      point->whole = profile->origin;
      point->part = profile->origin_part;
      point->velocity = profile->plan.start.v;
      point->acceleration = profile->plan.start.a;
      return;
    }
  }
  if (profile->has_next && !planner && !others && (!profile->moving || profile->at_once)) {
    begin_plan(profile, point);
  }
  if (!profile->moving) return;
  if (scurve_next(&profile->move, CYCLE_S, &state)) {
    point->whole = profile->origin;
    point->part = profile->origin_part;
    setpoint_advance(point, state.x);
    point->velocity = state.v;
    point->acceleration = state.a;
  } else {
    *point = (struct setpoint){.whole = profile->goal};
    profile->moving = false;
  }
}

void profile_watch(struct profile *profile, const struct axis_objects *o, int32_t actual) {
  int32_t away = (int32_t)((uint32_t)profile->goal - (uint32_t)actual);
  uint32_t size = away < 0 ? 0u - (uint32_t)away : (uint32_t)away;
  if (profile->moving || profile->has_next || profile->planning) {
    profile->within = 0;
    profile->reached = false;
  } else if (!profile->reached && size <= o->position_window) {
    profile->reached = profile->within++ >= o->position_window_time * CYCLES_PER_MS;
  } else if (!profile->reached) {
    profile->within = 0;
  }
}

/* Plans the change to `target`, if what it depends on is not what it was. */
static void plan_speed(struct profile *profile, const struct axis_objects *o, const struct setpoint *point,
                       float target) {
  uint32_t with[] = {o->profile_acceleration, o->profile_deceleration, o->profile_jerk};
  struct scurve_limits limits;
  if (profile->planned_speed && target == profile->planned_target && with[0] == profile->planned_with[0] &&
      with[1] == profile->planned_with[1] && with[2] == profile->planned_with[2]) {
    return;
  }
  limits.velocity = target;
  limits.acceleration = (float)with[0];
  limits.deceleration = (float)with[1];
  limits.jerk = (float)with[2] * 1000.0f;
  scurve_change(&profile->move, point->velocity, point->acceleration, target, &limits);
  for (int n = 0; n < 3; ++n) profile->planned_with[n] = with[n];
  if (target != profile->planned_target) profile->blocked = false;
  profile->speed = profile->planned_target = target;
  profile->planned_speed = profile->moving = true;
}

bool profile_run(struct profile *profile, const struct axis_objects *o, struct setpoint *point,
                 struct limits *limits, bool turn) {
  struct scurve_state state;
  float target = (float)o->target_velocity, most = limits->speed;
  bool limited = fabsf(target) > most;
  if (limited) target = target < 0.0f ? -most : most;
  if (!profile->planned_speed) profile->speed = point->velocity;
  if (turn) plan_speed(profile, o, point, target);
  if (!profile->moving || !scurve_next(&profile->move, CYCLE_S, &state)) {
    profile->moving = false;
    state = (struct scurve_state){0.0f, profile->speed, 0.0f};
  }
  /* Of limits, those of the position: a speed above a lowered limit falls as planned. */
  if (fabsf(state.v) > most) limits->speed = fabsf(state.v);
  if (!limiter_run(point, state.v, state.a, limits)) {
    if (profile->planned_speed && !profile->moving) profile->blocked = false;
    return limited || profile->blocked;
  }
  profile->planned_speed = profile->moving = false;
  profile->blocked = true;
  point->acceleration = 0.0f;
  return true;
}

void profile_watch_speed(struct profile *profile, const struct axis_objects *o, float actual) {
  if (fabsf(actual - (float)o->target_velocity) > (float)o->velocity_window) {
    profile->reached = false;
    profile->within = 0;
  } else if (!profile->reached) {
    profile->reached = profile->within++ >= o->velocity_window_time * CYCLES_PER_MS;
  }
  if (fabsf(actual) <= (float)o->velocity_threshold) {
    profile->zero = true;
    profile->faster = 0;
  } else if (profile->zero) {
    profile->zero = profile->faster++ < o->velocity_threshold_time * CYCLES_PER_MS;
  }
}
