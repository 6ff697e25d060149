/* SPDX-License-Identifier: Apache-2.0 */
/* One axis, see axis.h. Inside, positions are raw: those of the encoder since power on; the master's are
 * raw + home. */
#include "axis.h"

#include <math.h>

#include "al.h"
#include "cia402.h"
#include "coe.h"
#include "interpolator.h"
#include "profile.h"

#define CYCLE_S (CYCLE_US * 1e-6f)
#define CYCLES_PER_S (1e6f / CYCLE_US)
#define CYCLES_PER_MS (1000u / CYCLE_US)
#define FOLLOWING_ERROR 0x8611u
#define NOT_WATCHED 0xFFFFFFFFu
#define VELOCITY_FILTER 0.0625f

#define STATUS_REMOTE 0x0200u
#define STATUS_REACHED 0x0400u
#define STATUS_LIMIT 0x0800u
#define STATUS_MODE_12 0x1000u /* follows, acknowledged, attained */
#define STATUS_FOLLOWING_ERROR 0x2000u

static struct axis {
  struct cia402 machine;
  struct setpoint point;
  struct interpolator interpolator;
  struct profile profile;
  int32_t home, last_actual;
  float velocity; /* actual, filtered, increments/s */
  uint32_t beyond; /* cycles outside of the following error window */
  uint16_t control_was;
  int8_t mode;
  bool limited, attained, powered, seen;
} axes[AXES];

void axis_start(int n) {
  struct axis *axis = &axes[n];
  *axis = (struct axis){.mode = MODE_CSP};
  cia402_start(&axis->machine);
  profile_start(&axis->profile);
}

uint32_t axis_period(int n) {
  const struct axis_objects *o = &objects.axis[n];
  uint32_t us = o->period_value, cycles;
  for (int8_t index = o->period_index; index > -6 && us < 100000u; --index) us *= 10u;
  for (int8_t index = o->period_index; index < -6; ++index) us /= 10u;
  cycles = us > 100000u ? 100000u / CYCLE_US : us / CYCLE_US;
  return cycles ? cycles : 1u;
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
  axis->limited = target < o->position_limit[0] || target > o->position_limit[1];
  if (target < o->position_limit[0]) return o->position_limit[0];
  return target > o->position_limit[1] ? o->position_limit[1] : target;
}

/* A mode begins, from the present set-point. */
static void begin_mode(struct axis *axis, int n) {
  uint32_t period = axis_period(n);
  float slope = axis->point.velocity * (CYCLE_S * (float)period);
  axis->attained = axis->limited = false;
  axis->control_was = objects.axis[n].controlword;
  profile_start(&axis->profile);
  if (axis->mode == MODE_CSV) {
    interpolator_start(&axis->interpolator, (int32_t)axis->point.velocity, 0, period);
  } else {
    interpolator_start(&axis->interpolator, axis->point.whole, (int32_t)slope, period);
  }
}

void axis_enter_op(int n) { begin_mode(&axes[n], n); }

static void follow_position(struct axis *axis, const struct axis_objects *o, bool fresh, float rate) {
  struct interpolated out;
  if (fresh) {
    int32_t target = clipped(axis, o, o->target_position);
    uint32_t raw = (uint32_t)target + (uint32_t)o->position_offset - (uint32_t)axis->home;
    interpolator_target(&axis->interpolator, (int32_t)raw);
  }
  interpolator_step(&axis->interpolator, &out);
  axis->point.whole = out.whole;
  axis->point.part = out.part;
  axis->point.velocity = out.slope * rate;
  axis->point.acceleration = out.bend * rate * rate;
}

static void follow_velocity(struct axis *axis, const struct axis_objects *o, bool fresh, float rate) {
  struct interpolated out;
  float before = axis->point.velocity;
  if (fresh) {
    uint32_t target = (uint32_t)o->target_velocity + (uint32_t)o->velocity_offset;
    interpolator_target(&axis->interpolator, (int32_t)target);
  }
  interpolator_step(&axis->interpolator, &out);
  axis->point.velocity = (float)out.whole + out.part;
  axis->point.acceleration = out.slope * rate;
  setpoint_advance(&axis->point, (before + axis->point.velocity) * (0.5f * CYCLE_S));
}

static void home(struct axis *axis, const struct axis_objects *o, int32_t actual, uint16_t rising) {
  setpoint_brake(&axis->point, (float)o->profile_acceleration, CYCLE_S);
  if (rising & 0x10u) axis->attained = false;
  if (rising & 0x10u && axis->point.velocity == 0.0f) {
    axis->home = (int32_t)((uint32_t)o->home_offset - (uint32_t)actual);
    axis->attained = true;
  }
}

/* The set-point of a mode that runs. */
static void run_mode(struct axis *axis, int n, const struct axis_feedback *feedback, bool fresh,
                     struct axis_command *command) {
  struct axis_objects *o = &objects.axis[n];
  uint16_t rising = o->controlword & (uint16_t)~axis->control_was;
  float rate = axis->interpolator.per_span * (1024.0f * CYCLES_PER_S);
  int32_t torque;
  switch (axis->mode) {
    case MODE_CSP:
      follow_position(axis, o, fresh, rate);
      command->velocity = (float)o->velocity_offset;
      command->torque = o->torque_offset;
      break;
    case MODE_CSV:
      follow_velocity(axis, o, fresh, rate);
      command->torque = o->torque_offset;
      break;
    case MODE_CST:
      torque = o->target_torque + o->torque_offset;
      axis->limited = torque > o->max_torque || torque < -(int32_t)o->max_torque;
      if (torque > o->max_torque) torque = o->max_torque;
      if (torque < -(int32_t)o->max_torque) torque = -(int32_t)o->max_torque;
      if (torque > 32767) torque = 32767;
      if (torque < -32768) torque = -32768;
      command->torque = (int16_t)torque;
      command->torque_only = true;
      axis->point = (struct setpoint){.whole = feedback->position, .velocity = axis->velocity};
      break;
    case MODE_PROFILE_POSITION:
      if (rising & 0x10u) {
        profile_target(&axis->profile, o, clipped(axis, o, profile_wanted(&axis->profile, o, axis->home)),
                       axis->home);
      }
      profile_cycle(&axis->profile, o, &axis->point);
      break;
    case MODE_HOMING:
      home(axis, o, feedback->position, rising);
      break;
    default: /* no mode: comes to a stop */
      setpoint_brake(&axis->point, (float)o->profile_acceleration, CYCLE_S);
  }
  axis->control_was = o->controlword;
}

static void measure(struct axis *axis, struct axis_objects *o, const struct axis_feedback *feedback) {
  if (!axis->seen) axis->last_actual = feedback->position;
  axis->seen = true;
  float speed = (float)(int32_t)((uint32_t)feedback->position - (uint32_t)axis->last_actual) * CYCLES_PER_S;
  axis->last_actual = feedback->position;
  axis->velocity += (speed - axis->velocity) * VELOCITY_FILTER;
  o->position_actual = (int32_t)((uint32_t)feedback->position + (uint32_t)axis->home);
  o->velocity_actual = saturated(axis->velocity);
  o->torque_actual = feedback->torque;
}

/* Following error, and the fault when it stays. */
static void supervise(struct axis *axis, int n, const struct axis_feedback *feedback) {
  struct axis_objects *o = &objects.axis[n];
  int32_t error = (int32_t)((uint32_t)axis->point.whole - (uint32_t)feedback->position);
  uint32_t size = error < 0 ? 0u - (uint32_t)error : (uint32_t)error;
  o->following_error = error;
  o->position_demand = (int32_t)((uint32_t)axis->point.whole + (uint32_t)axis->home);
  if (axis->machine.state != DRIVE_ENABLED || o->following_window == NOT_WATCHED ||
      size <= o->following_window || axis->mode == MODE_CST) {
    axis->beyond = 0;
  } else if (axis->beyond++ >= o->following_timeout * CYCLES_PER_MS) {
    axis_fault(n, FOLLOWING_ERROR);
  }
}

static uint16_t status_of(const struct axis *axis, const struct axis_objects *o) {
  uint16_t status = cia402_status(&axis->machine);
  bool stops = cia402_ramp(&axis->machine, o) != RAMP_NONE, still = axis->point.velocity == 0.0f;
  bool runs = axis->machine.state == DRIVE_ENABLED && !stops;
  if (al_state() == AL_OP) status |= STATUS_REMOTE;
  if (axis->limited) status |= STATUS_LIMIT;
  if (axis->beyond && axis->mode != MODE_HOMING && axis->mode != MODE_CSV) {
    status |= STATUS_FOLLOWING_ERROR;
  }
  switch (axis->mode) {
    case MODE_PROFILE_POSITION:
      if (axis->profile.acknowledged) status |= STATUS_MODE_12;
      if (stops ? still : axis->profile.reached) status |= STATUS_REACHED;
      break;
    case MODE_HOMING:
      if (axis->attained) status |= STATUS_MODE_12;
      if (still || (axis->attained && !stops)) status |= STATUS_REACHED;
      break;
    default:
      if (runs && axis->mode) status |= STATUS_MODE_12;
  }
  return status;
}

static bool supported(int8_t mode) {
  return mode == 0 || mode == MODE_PROFILE_POSITION || mode == MODE_HOMING ||
         (mode >= MODE_CSP && mode <= MODE_CST);
}

void axis_cycle(int n, const struct axis_feedback *feedback, bool fresh, struct axis_command *command) {
  struct axis *axis = &axes[n];
  struct axis_objects *o = &objects.axis[n];
  enum drive_ramp ramp;
  *command = (struct axis_command){0};
  measure(axis, o, feedback);
  cia402_step(&axis->machine, o, al_state() == AL_OP, axis->point.velocity == 0.0f);
  if (feedback->fault) { /* cannot be reset while it lasts */
    axis_fault(n, feedback->fault);
  } else if (axis->machine.state == DRIVE_DISABLED) {
    tell(n, 0);
  }
  command->power = cia402_power(&axis->machine);
  if (!command->power) {
    axis->point = (struct setpoint){.whole = feedback->position};
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
  ramp = cia402_ramp(&axis->machine, o);
  if (command->power && ramp != RAMP_NONE) {
    setpoint_brake(&axis->point,
                   (float)(ramp == RAMP_PROFILE ? o->profile_acceleration : o->quick_stop_deceleration),
                   CYCLE_S);
    begin_mode(axis, n);
  } else if (command->power) {
    run_mode(axis, n, feedback, fresh, command);
  }
  if (axis->mode == MODE_PROFILE_POSITION) profile_watch(&axis->profile, o, feedback->position);
  supervise(axis, n, feedback);
  o->statusword = status_of(axis, o);
  command->position = axis->point.whole;
  command->fraction = axis->point.part;
  command->velocity += axis->point.velocity;
  command->acceleration = axis->point.acceleration;
  command->power = cia402_power(&axis->machine);
}
