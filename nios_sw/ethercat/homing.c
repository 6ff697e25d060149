/* SPDX-License-Identifier: Apache-2.0 */
/* Homing, see homing.h. */
#include "homing.h"

#include <math.h>

#include "cycle.h"

#define START 0x10u
#define WITHOUT_INDEX 16 /* methods 17 to 30 are 1 to 14 without the index */
#define SLOW 1.001f      /* of 6099:02: rounding */

struct homing_way {
  uint8_t signal;        /* the switch, 0: none */
  int8_t search, towards; /* directions of the search and of the approach */
  bool rises;            /* the edge of the approach leads onto the switch */
  bool between;          /* the switch is between the limit switches, which turn the search round */
};

static const struct homing_way ways[] = {
    {SWITCH_NEGATIVE, -1, 1, false, false}, /* 1 */
    {SWITCH_POSITIVE, 1, -1, false, false}, /* 2 */
    {SWITCH_HOME, 1, -1, false, false},     /* 3: the switch goes on to the positive end */
    {SWITCH_HOME, 1, 1, true, false},       /* 4 */
    {SWITCH_HOME, -1, 1, false, false},     /* 5: to the negative end */
    {SWITCH_HOME, -1, -1, true, false},     /* 6 */
    {SWITCH_HOME, 1, -1, false, true},      /* 7 */
    {SWITCH_HOME, 1, 1, true, true},        /* 8 */
    {SWITCH_HOME, 1, -1, true, true},       /* 9 */
    {SWITCH_HOME, 1, 1, false, true},       /* 10 */
    {SWITCH_HOME, -1, 1, false, true},      /* 11 */
    {SWITCH_HOME, -1, -1, true, true},      /* 12 */
    {SWITCH_HOME, -1, 1, true, true},       /* 13 */
    {SWITCH_HOME, -1, -1, false, true},     /* 14 */
};
static const struct homing_way to_index[] = {{0, 0, -1, false, false}, {0, 0, 1, false, false}}; /* 33, 34 */

static void go_on(struct homing *homing, enum homing_phase phase, int8_t direction) {
  homing->phase = phase;
  homing->direction = direction;
  homing->armed = false;
}

static void begin(struct homing *homing, int8_t method, uint16_t count) {
  homing->attained = homing->failed = homing->reversed = false;
  homing->count = count;
  homing->with_index = method <= WITHOUT_INDEX || method == 33 || method == 34;
  if (method >= 35) { /* 35, 37: here */
    homing->way = 0;
    go_on(homing, HOMING_FOUND, 0);
  } else if (method >= 33) {
    homing->way = &to_index[method - 33];
    go_on(homing, HOMING_INDEX, homing->way->towards);
  } else {
    homing->way = &ways[(method - 1) % WITHOUT_INDEX];
    go_on(homing, HOMING_SEARCH, homing->way->search);
  }
}

/* A limit switch in the direction of the motion. */
static void limit(struct homing *homing) {
  if (homing->phase == HOMING_SEARCH && homing->way->between && !homing->reversed) {
    homing->reversed = true;
    homing->direction = (int8_t)-homing->direction;
  } else {
    homing->failed = true;
    homing->phase = HOMING_IDLE;
  }
}

static void found(struct homing *homing, int32_t place) {
  homing->place = place;
  homing->phase = HOMING_FOUND;
}

/* What the switches and the index say: the next phase. A side of an edge counts when the axis is on its way there, not
 * while it still turns round. */
static void look(struct homing *homing, const struct axis_feedback *feedback, float speed, float slow) {
  const struct homing_way *way = homing->way;
  bool on = feedback->switches & way->signal, moves = speed * homing->direction > 0.0f;
  uint8_t end;
  switch (homing->phase) {
    case HOMING_SEARCH:
      if (on && way->rises) {
        go_on(homing, HOMING_LEAVE, (int8_t)-way->towards);
      } else if (on) {
        go_on(homing, HOMING_APPROACH, way->towards);
      }
      break;
    case HOMING_LEAVE:
      if (on && moves) homing->armed = true;
      if (!on && homing->armed) go_on(homing, HOMING_APPROACH, way->towards);
      break;
    case HOMING_APPROACH:
      if (on != way->rises) {
        if (moves && fabsf(speed) <= slow * SLOW) homing->armed = true;
      } else if (homing->armed && homing->with_index) {
        homing->count = feedback->index_count;
        homing->phase = HOMING_INDEX;
      } else if (homing->armed) {
        found(homing, feedback->position);
      }
      break;
    case HOMING_INDEX:
      if (moves && feedback->index_count != homing->count) found(homing, feedback->index_position);
      homing->count = feedback->index_count;
      break;
    default:
      break;
  }
  end = homing->direction > 0 ? SWITCH_POSITIVE : SWITCH_NEGATIVE;
  if (homing->phase != HOMING_FOUND && feedback->switches & end) limit(homing);
}

bool homing_cycle(struct homing *homing, const struct axis_objects *o, const struct axis_feedback *feedback,
                  bool begins, float most, struct setpoint *point) {
  float slow = (float)o->homing_speed[1], speed;
  if (slow > most) slow = most;
  if (begins) begin(homing, o->homing_method, feedback->index_count);
  if (!(o->controlword & START)) homing_stop(homing);
  if (homing->way && homing->phase != HOMING_IDLE && homing->phase != HOMING_FOUND) {
    look(homing, feedback, point->velocity, slow);
  }
  if (homing->phase == HOMING_IDLE || homing->phase == HOMING_FOUND) {
    setpoint_brake(point, (float)o->homing_acceleration, CYCLE_S);
    if (homing->phase == HOMING_IDLE || point->velocity != 0.0f) return false;
    if (!homing->way) homing->place = feedback->position;
    homing->attained = true;
    homing_stop(homing);
    return true;
  }
  speed = slow;
  if (homing->phase == HOMING_SEARCH || homing->phase == HOMING_LEAVE) {
    speed = (float)o->homing_speed[0];
    if (speed > most) speed = most;
  }
  setpoint_run(point, homing->direction > 0 ? speed : -speed, (float)o->homing_acceleration, CYCLE_S);
  return false;
}
