/* SPDX-License-Identifier: Apache-2.0 */
/* The measured motion of an axis, see motion.h. */
#include "motion.h"

#include "cycle.h"

#define SHORT 2
#define LONG (MOTION_CYCLES - 1)
#define STILL_WAY ((uint32_t)(57000.0f * LONG * CYCLE_S + 0.5f)) /* increments, at 57 000 increments/s */

void motion_start(struct motion *motion, int32_t position) {
  for (int n = 0; n < MOTION_CYCLES; ++n) motion->past[n] = position;
  motion->seen = true;
}

/* Increments moved in `cycles`, the last of which was `ago`. */
static int32_t way(const struct motion *motion, uint8_t cycles, uint8_t ago) {
  uint32_t last = motion->next + 2u * MOTION_CYCLES - 1u - ago;
  uint32_t to = (uint32_t)motion->past[last % MOTION_CYCLES];
  uint32_t from = (uint32_t)motion->past[(last - cycles) % MOTION_CYCLES];
  return (int32_t)(to - from);
}

float motion_speed(const struct motion *motion, float ahead) {
  float one = (float)way(motion, 1, 0) * CYCLES_PER_S;
  float two = (float)way(motion, 1, 1) * CYCLES_PER_S;
  float last = (float)way(motion, SHORT, 0) * (CYCLES_PER_S / SHORT);
  float before = (float)way(motion, SHORT, SHORT) * (CYCLES_PER_S / SHORT);
  float near = one + (one - two) * (0.5f + ahead); /* goes on changing like this */
  float far = last + (last - before) * ((1.0f + ahead) / SHORT);
  float sign = far < 0.0f ? -1.0f : 1.0f, least = sign * far;
  if (sign * near < least) least = sign * near;
  if (ahead > 0.0f && sign * last < least) least = sign * last;
  return least > 0.0f ? sign * least : 0.0f;
}

bool motion_still(const struct motion *motion) {
  int32_t moved = way(motion, LONG, 0);
  return (moved < 0 ? 0u - (uint32_t)moved : (uint32_t)moved) <= STILL_WAY;
}
