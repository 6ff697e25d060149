/* SPDX-License-Identifier: Apache-2.0 */
/* One axis, see axis.h. Inside, positions are raw: those of the encoder since power on; the master's are
 * raw + home. */
#include "axis.h"

#include <math.h>

#include "al.h"
#include "cia402.h"
#include "coe.h"
#include "cycle.h"
#include "held.h"
#include "homing.h"
#include "interpolator.h"
#include "limiter.h"
#include "motion.h"
#include "probe.h"
#include "profile.h"
#include "speed_limit.h"

#define FOLLOWING_ERROR 0x8611u
#define LIMITS 0x607Du /* objects, of the first axis */
#define PROBE 0x60B8u
#define PROBE_SOURCE 0x60D0u
#define PERIOD 0x60C2u
#define NOT_WATCHED 0xFFFFFFFFu
#define VELOCITY_FILTER 0.0625f
/* A stop ends when the axis is measured at rest, or this long after its set-point came to rest. */
#define SETTLE_CYCLES (200u * CYCLES_PER_MS)
/* Cycles of a stop until the axis has its first set-point, and those whose measurement corrects the set-point. */
#define DELAY_CYCLES 2
#define BEGIN_CYCLES 9
/* An axis follows its set-point after this many cycles in a row within NEAR increments of it. It has left the set-point of
 * its stop beyond LEFT increments. By JUMP increments the measurement is wrong: 2e11 increments/s2 in one cycle. */
#define NEAR_CYCLES 8
#define NEAR 1.0f
#define LEFT 2.0f
#define JUMP ((float)(1e-3 * CYCLE_100NS * CYCLE_100NS))

#define STATUS_REMOTE 0x0200u
#define STATUS_REACHED 0x0400u
#define STATUS_LIMIT 0x0800u
#define STATUS_MODE_12 0x1000u /* follows, acknowledged, attained */
#define STATUS_MODE_13 0x2000u /* following error, homing error */

static struct axis {
  struct cia402 machine;
  struct setpoint point;
  struct interpolator interpolator;
  struct profile profile;
  struct homing homing;
  struct probe probe;
  struct motion motion;
  struct speed_limit speed_limit;
  int32_t home, last_actual;
  float torque;   /* of profile torque, 0.1 % */
  float most;     /* speed, by 607F and 6080 as they were */
  float most_near; /* limiter_near of it */
  uint32_t most_by[2];
  uint32_t period_100ns; /* of the master, by 60C2 and SYNC0 as they were */
  uint32_t period_sync0; /* ns */
  uint8_t period_value;
  int8_t period_index;
  float velocity; /* actual, filtered, increments/s */
  uint32_t beyond;  /* cycles outside of the following error window */
  uint32_t settles; /* cycles of a stop since its set-point came to rest */
  uint8_t begun;    /* of BEGIN_CYCLES */
  uint8_t near;     /* cycles in a row in which the axis was near its set-point, NEAR_CYCLES at most */
  struct setpoint next; /* of a stop, in the cycle to come */
  uint16_t control_was;
  int8_t mode;
  enum drive_state stopping; /* the state whose stop is under way */
  bool limited, clipped, powered, stops;
  bool behind;   /* a target, because of a limit */
  bool along;    /* a stop: the set-point of before it, braked */
} axes[AXES];

/* A motor revolution, of 6080 and 608F, in the units of 2011: a millimetre, or a turn of tilt and rotation. */
#define LINEAR_AXES 3
#define MILLIMETRE 1e-3f
#define TURN 6.28318530717958647692f

static int turn; /* the axis that may plan a change of speed in this cycle, so that no pass gets long */

void axis_start(int n) {
  struct axis *axis = &axes[n];
  turn = 0;
  *axis = (struct axis){.mode = MODE_CSP};
  cia402_start(&axis->machine);
  profile_start(&axis->profile);
  objects.axis[n].encoder_increments = objects.axis[n].feed =
      (uint32_t)((n < LINEAR_AXES ? MILLIMETRE : TURN) / objects.increment[n] + 0.5f);
}

/* Of 60C2; its index is a power of ten of a second, from -6 on. */
static uint32_t period_us(uint8_t value, int8_t index) {
  uint32_t us = value;
  for (; index > -6; --index) us *= 10u;
  return us;
}

/* 60C2 cannot state 62.5 us. A SYNC0 less than a microsecond from it is more exact. */
static uint32_t period_100ns(const struct axis_objects *o, uint32_t sync0) {
  uint32_t us = period_us(o->period_value, o->period_index), whole = sync0 / 1000u;
  return us == whole || (us == whole + 1u && sync0 % 1000u) ? sync0 / 100u : us * 10u;
}

uint32_t axis_period_100ns(int n) {
  const struct axis_objects *o = &objects.axis[n];
  struct axis *axis = &axes[n];
  uint32_t sync0 = application_sync0_ns();
  if (o->period_value != axis->period_value || o->period_index != axis->period_index || sync0 != axis->period_sync0) {
    axis->period_value = o->period_value;
    axis->period_index = o->period_index;
    axis->period_sync0 = sync0;
    axis->period_100ns = period_100ns(o, sync0);
  }
  return axis->period_100ns;
}

uint32_t axis_check(uint16_t index, uint8_t subindex, uint32_t value) {
  const struct axis_objects *o;
  uint16_t first;
  uint32_t us;
  if (index < AXIS_FIRST || index >= AXIS_FIRST + AXES * AXIS_STEP) return 0;
  o = &objects.axis[(index - AXIS_FIRST) / AXIS_STEP];
  first = (uint16_t)(AXIS_FIRST + (index - AXIS_FIRST) % AXIS_STEP);
  if (first == LIMITS) {
    int32_t low = subindex == 1 ? (int32_t)value : o->position_limit[0];
    int32_t high = subindex == 2 ? (int32_t)value : o->position_limit[1];
    return low > high ? ABORT_MOST_BELOW_LEAST : 0;
  }
  if (first == PROBE) return probe_valid((uint16_t)value, o->probe_source) ? 0 : ABORT_RANGE;
  if (first == PROBE_SOURCE) {
    int16_t sources[PROBES] = {o->probe_source[0], o->probe_source[1]};
    sources[subindex == 2] = (int16_t)value;
    return probe_valid(o->probe_function, sources) ? 0 : ABORT_RANGE;
  }
  if (first != PERIOD) return 0;
  us = subindex == 1 ? period_us((uint8_t)value, o->period_index) : period_us(o->period_value, (int8_t)value);
  return us * 10u < CYCLE_100NS ? ABORT_RANGE : 0;
}

/* The axis has this error from now on, 0: none; an emergency if that is new. */
static void tell(int n, uint16_t error) {
  if (objects.axis[n].error_code == error) return;
  objects.axis[n].error_code = error;
  application_errors();
  coe_emergency(error, (uint8_t)n);
}

void axis_fault(int n, uint16_t error) {
  struct axis *axis = &axes[n];
  if (axis->machine.state == DRIVE_FAULT || axis->machine.state == DRIVE_REACTION) return;
  cia402_fault(&axis->machine);
  tell(n, error);
}

void axis_leave_op(int n, uint16_t error) {
  if (error) {
    axis_fault(n, error);
  } else {
    cia402_quick_stop(&axes[n].machine);
  }
}

static int32_t clipped(struct axis *axis, const struct axis_objects *o, int32_t target) {
  axis->limited = axis->clipped = target < o->position_limit[0] || target > o->position_limit[1];
  if (target < o->position_limit[0]) return o->position_limit[0];
  return target > o->position_limit[1] ? o->position_limit[1] : target;
}

/* A mode begins, from the present set-point. */
static void begin_mode(struct axis *axis, int n) {
  uint32_t period = axis_period_100ns(n);
  float slope = axis->point.velocity * (1e-7f * (float)period);
  axis->limited = axis->clipped = axis->behind = false;
  axis->control_was = objects.axis[n].controlword;
  profile_start(&axis->profile);
  homing_stop(&axis->homing);
  speed_limit_start(&axis->speed_limit, axis->velocity);
  if (axis->mode == MODE_PROFILE_VELOCITY) axis->profile.reached = false;
  if (axis->mode == MODE_PROFILE_TORQUE) axis->torque = (float)objects.axis[n].torque_actual;
  if (axis->mode == MODE_CSV) {
    interpolator_start(&axis->interpolator, (int32_t)axis->point.velocity, 0, period);
  } else {
    interpolator_start(&axis->interpolator, axis->point.whole, (int32_t)slope, period);
  }
}

void axis_enter_op(int n) { begin_mode(&axes[n], n); }

/* Takes over the greatest speed when its objects change. */
static void see_most(struct axis *axis, const struct axis_objects *o) {
  if (o->max_velocity != axis->most_by[0] || o->max_motor_speed != axis->most_by[1]) {
    float motor = (float)o->max_motor_speed * (float)o->encoder_increments / 60.0f;
    axis->most_by[0] = o->max_velocity;
    axis->most_by[1] = o->max_motor_speed;
    axis->most = (float)o->max_velocity;
    if (motor < axis->most) axis->most = motor;
    axis->most_near = limiter_near(axis->most);
  }
}

/* The greatest speed of a set-point. */
static float most_of(struct axis *axis, const struct axis_objects *o) {
  see_most(axis, o);
  return axis->most;
}

static struct limits limits_of(struct axis *axis, const struct axis_objects *o) {
  return (struct limits){.speed = most_of(axis, o),
                         .deceleration = (float)o->quick_stop_deceleration,
                         .low = o->position_limit[0],
                         .high = o->position_limit[1],
                         .home = axis->home};
}

static void follow_position(struct axis *axis, const struct axis_objects *o, bool fresh) {
  float rate = axis->interpolator.per_s;
  struct limits limits;
  struct interpolated out;
  struct setpoint wanted, slower;
  if (fresh) {
    int32_t target = clipped(axis, o, o->target_position);
    uint32_t raw = (uint32_t)target + (uint32_t)o->position_offset - (uint32_t)axis->home;
    interpolator_target(&axis->interpolator, (int32_t)raw);
  }
  interpolator_step(&axis->interpolator, &out);
  wanted.whole = out.whole;
  wanted.part = out.part;
  wanted.velocity = out.slope * rate;
  wanted.acceleration = out.bend * rate * rate;
  see_most(axis, o);
  if (!axis->behind && !limiter_bounds(o->position_limit[0], o->position_limit[1]) &&
      limiter_allows(limiter_step(&axis->point, &wanted), axis->most_near)) { /* most cycles */
    axis->point = wanted;
    axis->limited = axis->clipped;
    return;
  }
  limits = limits_of(axis, o);
  slower = wanted; /* the one whose address is taken, so that the other one stays in registers */
  axis->limited = limiter_follow(&axis->point, &slower, &limits, &axis->behind) || axis->clipped;
}

static void follow_velocity(struct axis *axis, const struct axis_objects *o, bool fresh) {
  float rate = axis->interpolator.per_s;
  struct limits limits = limits_of(axis, o);
  struct interpolated out;
  if (fresh) {
    uint32_t target = (uint32_t)o->target_velocity + (uint32_t)o->velocity_offset;
    interpolator_target(&axis->interpolator, (int32_t)target);
  }
  interpolator_step(&axis->interpolator, &out);
  axis->limited = limiter_run(&axis->point, (float)out.whole + out.part, out.slope * rate, &limits);
}

/* The torque within its limit, instead of the law's, unless that would be faster than the limits of the speed. */
static void give_torque(struct axis *axis, const struct axis_objects *o, const struct axis_feedback *feedback,
                        int32_t torque, struct axis_command *command) {
  struct torque_wanted wanted;
  axis->limited = torque > o->max_torque || torque < -(int32_t)o->max_torque;
  if (torque > o->max_torque) torque = o->max_torque;
  if (torque < -(int32_t)o->max_torque) torque = -(int32_t)o->max_torque;
  if (torque > 32767) torque = 32767;
  if (torque < -32768) torque = -32768;
  wanted = (struct torque_wanted){.torque = (float)torque,
                                  .velocity = axis->velocity,
                                  .most = most_of(axis, o),
                                  .deceleration = (float)o->quick_stop_deceleration};
  if (speed_limit_cycle(&axis->speed_limit, &axis->point, feedback, &wanted)) {
    axis->limited = true;
    return;
  }
  command->torque = (int16_t)torque;
  command->torque_only = true;
  axis->point = (struct setpoint){.whole = feedback->position, .velocity = axis->velocity};
}

/* Profile torque: the target along the slope. */
static void slope_torque(struct axis *axis, const struct axis_objects *o) {
  float away = (float)o->target_torque - axis->torque, step = (float)o->torque_slope * CYCLE_S;
  if (fabsf(away) <= step) {
    axis->torque = (float)o->target_torque;
  } else {
    axis->torque += away > 0.0f ? step : -step;
  }
}

/* The set-point of a mode that runs. What most cycles do comes first, here and below. */
static void run_mode(struct axis *axis, int n, const struct axis_objects *o, const struct axis_feedback *feedback,
                     bool fresh, struct axis_command *command) {
  uint16_t rising = o->controlword & (uint16_t)~axis->control_was;
  struct limits limits;
  axis->control_was = o->controlword;
  if (axis->mode == MODE_CSP) { /* the longest one: not by the table of the switch */
    follow_position(axis, o, fresh);
    command->velocity = (float)o->velocity_offset;
    command->torque = o->torque_offset;
    return;
  }
  switch (axis->mode) {
    case MODE_CSV:
      follow_velocity(axis, o, fresh);
      command->torque = o->torque_offset;
      break;
    case MODE_CST:
      give_torque(axis, o, feedback, o->target_torque + o->torque_offset, command);
      break;
    case MODE_PROFILE_TORQUE:
      slope_torque(axis, o);
      give_torque(axis, o, feedback, (int32_t)axis->torque, command);
      break;
    case MODE_PROFILE_VELOCITY:
      limits = limits_of(axis, o);
      axis->limited = profile_run(&axis->profile, o, &axis->point, &limits, turn == n);
      break;
    case MODE_PROFILE_POSITION:
      if (rising & 0x10u) {
        profile_target(&axis->profile, o, clipped(axis, o, profile_wanted(&axis->profile, o, axis->home)),
                       axis->home, most_of(axis, o));
      }
      profile_cycle(&axis->profile, o, &axis->point);
      break;
    case MODE_HOMING:
      if (homing_cycle(&axis->homing, o, feedback, rising & 0x10u, most_of(axis, o), &axis->point)) {
        axis->home = (int32_t)((uint32_t)o->home_offset - (uint32_t)axis->homing.place);
      }
      break;
    default: /* no mode: comes to a stop */
      setpoint_brake(&axis->point, (float)o->profile_deceleration, CYCLE_S);
  }
}

static void measure(struct axis *axis, struct axis_objects *o, const struct axis_feedback *feedback) {
  if (!axis->motion.seen) {
    axis->last_actual = feedback->position;
    motion_start(&axis->motion, feedback->position);
  }
  motion_take(&axis->motion, feedback->position);
  float speed = (float)(int32_t)((uint32_t)feedback->position - (uint32_t)axis->last_actual) * CYCLES_PER_S;
  axis->last_actual = feedback->position;
  axis->velocity += (speed - axis->velocity) * VELOCITY_FILTER;
  o->position_actual = (int32_t)((uint32_t)feedback->position + (uint32_t)axis->home);
  o->velocity_actual = saturated(axis->velocity);
  o->torque_actual = feedback->torque;
}

/* Following error of the set-point that the law has now, and the fault when it stays: its stop begins in this
 * cycle. */
static void supervise(struct axis *axis, int n, struct axis_objects *o, const struct axis_feedback *feedback) {
  bool torque = axis->mode == MODE_CST || axis->mode == MODE_PROFILE_TORQUE, tracks = axis->powered && !torque;
  int32_t error = (int32_t)((uint32_t)axis->point.whole - (uint32_t)feedback->position);
  bool near = fabsf((float)error + axis->point.part) <= NEAR;
  uint32_t size;
  if (!tracks) error = 0;
  size = error < 0 ? 0u - (uint32_t)error : (uint32_t)error;
  o->following_error = error;
  if (!near || (axis->powered && torque)) {
    axis->near = 0;
  } else if (axis->near < NEAR_CYCLES) {
    ++axis->near;
  }
  if (axis->machine.state != DRIVE_ENABLED || o->following_window == NOT_WATCHED ||
      size <= o->following_window) {
    axis->beyond = 0;
  } else if (axis->beyond++ >= o->following_timeout * CYCLES_PER_MS) {
    axis_fault(n, FOLLOWING_ERROR);
  }
}

/* Whether the axis rests: its set-point does, and what is measured, or it cannot come to rest by its set-point. */
static bool rests(const struct axis *axis) {
  return axis->point.velocity == 0.0f && (motion_still(&axis->motion) || axis->settles >= SETTLE_CYCLES);
}

static float away(const struct setpoint *point, int32_t position) {
  return (float)(int32_t)((uint32_t)position - (uint32_t)point->whole) - point->part;
}

/* A stop that begins brakes along the set-point that the axis follows. The law has the set-point of this cycle until the
 * next one, so the axis goes on with its acceleration, of which the machine does at least `most`; the set-point moves into
 * the increment in which the axis is measured. */
static void begin_along(struct axis *axis, float most, float ahead) {
  float change = axis->point.acceleration * CYCLE_S, before = axis->point.velocity, into = 0.0f;
  if (fabsf(change) > most * CYCLE_S) change = copysignf(most * CYCLE_S, change);
  if (fabsf(ahead) > 0.5f) into = ahead - copysignf(0.5f, ahead);
  axis->next = axis->point;
  axis->next.velocity += change;
  setpoint_advance(&axis->next, into + (before + 0.5f * change) * CYCLE_S);
}

/* The set-point of a stop that begins is the motion of the axis as far as it is known: the set-point that the axis
 * follows, as long as it does; or at first what is measured, with the braking that the law has not done yet, then this
 * prediction corrected by each position, by the gains of the least squares of all of them (expanding-memory g-h filter:
 * E. Brookner, Tracking and Kalman Filtering Made Easy, 1998, 1.2.10). So the axis and its ramp have the same speed,
 * whatever the loop of the law is. */
static void begin_stop(struct axis *axis, float most, int32_t position) {
  float ahead = away(&axis->point, position);
  if (axis->begun == 0) axis->along = axis->near == NEAR_CYCLES;
  if (axis->along && fabsf(ahead) > LEFT && fabsf(ahead) < JUMP) {
    axis->along = false;
    axis->begun = 0;
  }
  if (axis->along) {
    if (axis->begun == 0) begin_along(axis, most, ahead);
  } else if (axis->begun < DELAY_CYCLES) {
    float speed = motion_speed(&axis->motion, axis->begun ? 0.0f : 1.0f);
    float change = axis->begun ? axis->point.acceleration * CYCLE_S : 0.0f;
    axis->next = (struct setpoint){.whole = position, .velocity = speed + change};
    setpoint_advance(&axis->next, (speed + 0.5f * change) * CYCLE_S);
  } else {
    float n = (float)(axis->begun - (DELAY_CYCLES - 1));
    float share = 2.0f / ((n + 1.0f) * (n + 2.0f));
    axis->next.velocity += 3.0f * share * ahead * CYCLES_PER_S;
    setpoint_advance(&axis->next, (2.0f * n + 4.0f) * share * ahead);
  }
  ++axis->begun;
}

/* One cycle of a stop. It starts from where the axis is measured and as fast as it moves: after a
 * following error the set-point may be far away and fast. */
static void stop(struct axis *axis, int n, const struct axis_feedback *feedback, enum drive_ramp ramp) {
  const struct axis_objects *o = &objects.axis[n];
  if (!axis->stops || axis->stopping != axis->machine.state) axis->settles = axis->begun = 0;
  if (axis->begun < BEGIN_CYCLES) begin_stop(axis, (float)o->quick_stop_deceleration, feedback->position);
  axis->stopping = axis->machine.state;
  axis->point = axis->next;
  if (axis->point.velocity == 0.0f && axis->settles < SETTLE_CYCLES) ++axis->settles;
  setpoint_brake(&axis->next,
                 (float)(ramp == RAMP_PROFILE ? o->profile_deceleration : o->quick_stop_deceleration), CYCLE_S);
  axis->point.acceleration = axis->next.acceleration;
  begin_mode(axis, n);
}

static uint16_t status_of(const struct axis *axis, const struct axis_objects *o, bool remote, bool stops) {
  uint16_t status = cia402_status(&axis->machine);
  bool still = (stops || axis->mode == MODE_HOMING) && rests(axis);
  bool runs = axis->machine.state == DRIVE_ENABLED && !stops;
  if (remote) status |= STATUS_REMOTE;
  if (axis->limited) status |= STATUS_LIMIT;
  /* In the other modes bit 13 has another meaning, or none. */
  if (axis->beyond && (axis->mode == MODE_PROFILE_POSITION || axis->mode == MODE_CSP)) status |= STATUS_MODE_13;
  switch (axis->mode) {
    case MODE_PROFILE_POSITION:
      if (axis->profile.acknowledged) status |= STATUS_MODE_12;
      if (stops ? still : axis->profile.reached) status |= STATUS_REACHED;
      break;
    case MODE_PROFILE_VELOCITY:
      if (axis->profile.zero) status |= STATUS_MODE_12;
      if (stops ? still : runs && axis->profile.reached) status |= STATUS_REACHED;
      break;
    case MODE_PROFILE_TORQUE:
      if (stops ? still : runs && axis->torque == (float)o->target_torque && !axis->limited) status |= STATUS_REACHED;
      break;
    case MODE_HOMING:
      if (axis->homing.attained) status |= STATUS_MODE_12;
      if (axis->homing.failed) status |= STATUS_MODE_13;
      if (axis->homing.phase != HOMING_IDLE) break; /* under way */
      if (still || (axis->homing.attained && !stops)) status |= STATUS_REACHED;
      break;
    default:
      if (runs && axis->mode) status |= STATUS_MODE_12;
      if (still) status |= STATUS_REACHED;
  }
  return status;
}

static bool supported(int8_t mode) {
  return mode == 0 || mode == MODE_PROFILE_POSITION || mode == MODE_HOMING ||
         mode == MODE_PROFILE_VELOCITY || mode == MODE_PROFILE_TORQUE || (mode >= MODE_CSP && mode <= MODE_CST);
}

static void cycle(struct axis *axis, struct axis_objects *o, int n, const struct axis_feedback *feedback, bool fresh,
                  struct axis_command *command) {
  enum drive_ramp ramp = RAMP_NONE;
  bool remote = al_state() == AL_OP;
  int32_t before = axis->last_actual;
  command->velocity = 0.0f;
  command->torque = 0;
  command->torque_only = false;
  measure(axis, o, feedback);
  if (probe_active(&axis->probe, o)) probe_cycle(&axis->probe, o, feedback, before, axis->home);
  if (!cia402_stays(&axis->machine, o, remote)) cia402_step(&axis->machine, o, remote, rests(axis));
  supervise(axis, n, o, feedback);
  if (feedback->fault) { /* cannot be reset while it lasts */
    axis_fault(n, feedback->fault);
  } else if (axis->machine.state == DRIVE_DISABLED) {
    tell(n, 0);
  }
  command->power = cia402_power(&axis->machine);
  if (!command->power) {
    axis->point = (struct setpoint){.whole = feedback->position};
    axis->near = NEAR_CYCLES;
    profile_drop(&axis->profile);
  } else if (!axis->powered) {
    begin_mode(axis, n);
  }
  axis->powered = command->power;
  if (o->mode != axis->mode && supported(o->mode)) {
    axis->mode = o->mode;
    begin_mode(axis, n);
  }
  o->mode_display = axis->mode;
  if (!cia402_goes_on(&axis->machine, o)) ramp = cia402_ramp(&axis->machine, o);
  if (command->power && ramp != RAMP_NONE) {
    stop(axis, n, feedback, ramp);
  } else if (command->power) {
    run_mode(axis, n, o, feedback, fresh, command);
  }
  axis->stops = command->power && ramp != RAMP_NONE;
  if (!axis->stops) axis->settles = 0;
  if (axis->mode == MODE_PROFILE_POSITION) profile_watch(&axis->profile, o, feedback->position);
  if (axis->mode == MODE_PROFILE_VELOCITY) profile_watch_speed(&axis->profile, o, axis->velocity);
  o->position_demand = (int32_t)((uint32_t)axis->point.whole + (uint32_t)axis->home);
  o->velocity_demand = saturated(axis->point.velocity);
  o->torque_demand = command->torque_only ? command->torque : feedback->torque;
  o->statusword = status_of(axis, o, remote, ramp != RAMP_NONE);
  command->position = axis->point.whole;
  command->fraction = axis->point.part;
  command->velocity += axis->point.velocity;
  command->acceleration = axis->point.acceleration;
}

void axis_cycles(const struct feedback *feedback, bool fresh, struct command *command) {
  const struct axis_feedback *from = feedback->axis;
  struct axis_command *to = command->axis;
  struct axis_objects *o = objects.axis;
  struct axis *axis = axes;
  HELD(axis);
  HELD(o);
  turn = turn + 1 < AXES ? turn + 1 : 0;
  for (int n = 0; n < AXES; ++n) cycle(axis++, o++, n, from++, fresh, to++);
}
