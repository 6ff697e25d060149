/* SPDX-License-Identifier: Apache-2.0 */
/* Set-point of an axis, and two modes. Profile position: targets one after the other or at once, each
 * reached by a jerk-limited move (scurve.h). Profile velocity: each target reached by a jerk-limited change of speed,
 * and held. */
#ifndef ETHERCAT_PROFILE_H
#define ETHERCAT_PROFILE_H

#include <stdbool.h>
#include <stdint.h>

#include "dictionary.h"
#include "scurve.h"

struct setpoint {
  int32_t whole;
  float part;         /* |part| < 1 */
  float velocity;     /* increments/s */
  float acceleration; /* increments/s2 */
};

struct profile {
  struct scurve move, planned;
  struct scurve_plan plan;
  int32_t origin, goal, next; /* of the move under way, of the one planned or to be planned; raw */
  int32_t plan_origin, plan_goal;
  float origin_part, plan_origin_part;
  struct scurve_limits limits;
  uint8_t planning;           /* cycles until the planned move begins, 0: nothing is planned */
  bool moving, has_next, at_once, acknowledged, reached;
  uint32_t within;            /* cycles in the position window, or in the velocity window */
  /* Profile velocity: what the change of speed was planned with, and the speed after it. */
  bool planned_speed, blocked; /* blocked: a position limit holds the axis */
  bool zero;                  /* the axis is slower than the threshold */
  float speed, planned_target;
  uint32_t planned_with[3];   /* 6083, 6084, 60A4 */
  uint32_t faster;            /* cycles above the threshold */
};

struct limits;

void setpoint_advance(struct setpoint *point, float way);
/* Towards this speed by this acceleration, for one control cycle. */
void setpoint_run(struct setpoint *point, float velocity, float acceleration, float cycle);
/* Less speed by this deceleration, for one control cycle. */
void setpoint_brake(struct setpoint *point, float deceleration, float cycle);
static inline int32_t saturated(float value) {
  if (value >= 2147483520.0f) return 2147483520;
  return value <= -2147483520.0f ? -2147483520 : (int32_t)value;
}

void profile_start(struct profile *profile);
/* Without power: no plan goes on, so that another axis may plan. */
void profile_drop(struct profile *profile);
/* The target that the objects ask for, in the master's positions. */
int32_t profile_wanted(const struct profile *profile, const struct axis_objects *o, int32_t home);
/* A new set-point (rising bit 4 of the controlword); most: the greatest speed. */
void profile_target(struct profile *profile, const struct axis_objects *o, int32_t target, int32_t home, float most);
void profile_cycle(struct profile *profile, const struct axis_objects *o, struct setpoint *point);
void profile_watch(struct profile *profile, const struct axis_objects *o, int32_t actual);
/* Profile velocity, one control cycle; turn: a change of speed may be planned in this one. limits->speed is changed.
 * Whether a limit holds the set-point or its target. */
bool profile_run(struct profile *profile, const struct axis_objects *o, struct setpoint *point,
                 struct limits *limits, bool turn);
/* Of profile velocity: target reached (606D, 606E) and speed 0 (606F, 6070) by the measured speed. */
void profile_watch_speed(struct profile *profile, const struct axis_objects *o, float actual);

#endif
