/* SPDX-License-Identifier: Apache-2.0 */
/* The measured motion of an axis: what a stop starts from, and whether the axis is at rest. */
#ifndef ETHERCAT_MOTION_H
#define ETHERCAT_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#define MOTION_CYCLES 8 /* in which the axis moves by STILL_WAY at most when it is at rest */

struct motion {
  int32_t past[MOTION_CYCLES]; /* positions, the last MOTION_CYCLES of them */
  uint8_t next;                /* place of the oldest one */
  bool seen;
};

/* It has been at this position. */
void motion_start(struct motion *motion, int32_t position);
/* One control cycle. */
static inline void motion_take(struct motion *motion, int32_t position) {
  motion->past[motion->next] = position;
  motion->next = (uint8_t)((motion->next + 1u) % MOTION_CYCLES);
}
/* Speed `ahead` cycles after the last position (0 or 1), increments/s: the least of what the changes over one and
 * over two cycles lead to, and for a time ahead of what was measured over two cycles; 0 if they disagree about the
 * direction. So a stop that starts with it does not accelerate an axis that is braking already. */
float motion_speed(const struct motion *motion, float ahead);
bool motion_still(const struct motion *motion);

#endif
