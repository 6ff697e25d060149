/* SPDX-License-Identifier: Apache-2.0 */
/* The measured motion of an axis, see motion.h. */
#include "motion.h"

#include "gen/objects.h"

#define CYCLES_PER_S (1e6f / CYCLE_US)
#define SHORT 2
#define LONG (MOTION_CYCLES - 1)
#define STILL_WAY 40u /* increments: 57 000 increments/s */

void motion_take(struct motion *motion, int32_t position) {
  for (int n = 0; !motion->seen && n < MOTION_CYCLES; ++n) motion->past[n] = position;
  motion->seen = true;
  motion->past[motion->next] = position;
  motion->next = (uint8_t)((motion->next + 1u) % MOTION_CYCLES);
}

/* Increments moved in `cycles`, the last of which was `ago`. */
static int32_t way(const struct motion *motion, uint8_t cycles, uint8_t ago) {
  uint32_t last = motion->next + 2u * MOTION_CYCLES - 1u - ago;
  uint32_t to = (uint32_t)motion->past[last % MOTION_CYCLES];
  uint32_t from = (uint32_t)motion->past[(last - cycles) % MOTION_CYCLES];
  return (int32_t)(to - from);
}

float motion_speed(const struct motion *motion) {
  float last = (float)way(motion, SHORT, 0) * (CYCLES_PER_S / SHORT);
  float before = (float)way(motion, SHORT, SHORT) * (CYCLES_PER_S / SHORT);
  float mean = (float)way(motion, LONG, 0) * (CYCLES_PER_S / LONG);
  float sign = last < 0.0f ? -1.0f : 1.0f, least = sign * last;
  float next = least + (least - sign * before); /* goes on changing like this */
  if (next < least) least = next;
  if (sign * mean < least) least = sign * mean;
  return least > 0.0f ? sign * least : 0.0f;
}

bool motion_still(const struct motion *motion) {
  int32_t moved = way(motion, LONG, 0);
  return (moved < 0 ? 0u - (uint32_t)moved : (uint32_t)moved) <= STILL_WAY;
}
