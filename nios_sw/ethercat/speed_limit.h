/* SPDX-License-Identifier: Apache-2.0 */
/* Speed limit of the torque modes. An axis that reaches the greatest speed gets a set-point that runs with it, and the law
 * holds it there. When the law needs more torque than is asked for, the axis has the torque that is asked for again. So
 * the axis always has the lesser one of the two torques. */
#ifndef ETHERCAT_SPEED_LIMIT_H
#define ETHERCAT_SPEED_LIMIT_H

#include <stdbool.h>

#include "application.h"
#include "profile.h"

struct speed_limit {
  float slower; /* the filtered speed, filtered once more */
  float needs;  /* torque of the law at the limit, filtered, 0.1 % */
  float sign;   /* of the speed that is held, or was last */
  bool holds;   /* the law holds the speed */
  bool free;    /* the law gave the axis back: the torque asked for is less than `needs` */
};

/* What one control cycle knows of an axis in a torque mode. */
struct torque_wanted {
  float torque;       /* 0.1 % */
  float velocity;     /* measured, filtered as axis.c does, increments/s */
  float most;         /* speed, increments/s */
  float deceleration; /* to that speed, increments/s2 */
};

void speed_limit_start(struct speed_limit *limit, float velocity);
/* One control cycle. True: the law is to follow `point`; false: the axis has the torque, and `point` is unchanged. */
bool speed_limit_cycle(struct speed_limit *limit, struct setpoint *point, const struct axis_feedback *feedback,
                       const struct torque_wanted *wanted);

#endif
