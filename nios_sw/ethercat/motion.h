/* SPDX-License-Identifier: Apache-2.0 */
/* The measured motion of an axis: what a stop starts from, and whether the axis stands still. */
#ifndef ETHERCAT_MOTION_H
#define ETHERCAT_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#define MOTION_CYCLES 8 /* in which the axis moves by STILL_WAY at most to stand still */

struct motion {
  int32_t past[MOTION_CYCLES]; /* positions, the last MOTION_CYCLES of them */
  uint8_t next;                /* place of the oldest one */
  bool seen;
};

/* One control cycle. */
void motion_take(struct motion *motion, int32_t position);
/* Speed `ahead` cycles after the last position (0 or 1), increments/s: the least of what the changes over one and
 * over two cycles lead to, and for a time ahead of what was measured over two cycles; 0 if they disagree about the
 * direction. So a stop that starts with it does not accelerate an axis that is braking already. */
float motion_speed(const struct motion *motion, float ahead);
bool motion_still(const struct motion *motion);

#endif
