/* SPDX-License-Identifier: Apache-2.0 */
/* Homing (CiA 402-2, IEC 61800-7-201): ways to the home position by switches and the index of the encoder. A way is a
 * search for a switch with the speed 6099:01, from the far side if need be, then an approach with 6099:02 to an edge of
 * the switch, and on to the next index. A switch is seen once in a control cycle; the place of an index is that of the
 * encoder. Speeds in increments/s. */
#ifndef ETHERCAT_HOMING_H
#define ETHERCAT_HOMING_H

#include <stdbool.h>
#include <stdint.h>

#include "application.h"
#include "profile.h"

struct homing_way;

enum homing_phase {
  HOMING_IDLE,
  HOMING_SEARCH,   /* for the switch */
  HOMING_LEAVE,    /* the switch, so that it is met from the other side */
  HOMING_APPROACH, /* to its edge */
  HOMING_INDEX,    /* to the next index */
  HOMING_FOUND     /* comes to rest */
};

struct homing {
  const struct homing_way *way;
  int32_t place;    /* of the home position, raw */
  enum homing_phase phase;
  int8_t direction; /* of the motion */
  uint16_t count;   /* of the index, when the search for the next one began */
  bool with_index;
  bool armed;       /* the side before the edge has been seen */
  bool reversed;    /* at a limit switch */
  bool attained;    /* homed since power on: a change of the mode leaves it */
  bool failed;      /* until the next homing begins */
};

/* Ends a homing that is under way. */
static inline void homing_stop(struct homing *homing) { homing->phase = HOMING_IDLE; }

/* One control cycle. begins: bit 4 of the controlword rises; most: the greatest speed. Whether the home position has
 * been found, at homing->place, and the set-point is at rest. */
bool homing_cycle(struct homing *homing, const struct axis_objects *o, const struct axis_feedback *feedback,
                  bool begins, float most, struct setpoint *point);

#endif
