/* SPDX-License-Identifier: Apache-2.0 */
/* Touch probe (CiA 402-2): the position of an axis when an edge comes, 60B8 to 60BD, 60D0 and 60D5 to 60D8. Sources: an
 * input of the device, without 60D0 input 1 for probe 1 and input 2 for probe 2, or the index of the axis' encoder, which
 * has rising edges only. The place of an index is exact. The place of an edge of an input lies between the positions of the two control ticks around it, by the
 * age of the edge that the machine gives; a machine without ages gives 0: the position of the tick that saw it. */
#ifndef ETHERCAT_PROBE_H
#define ETHERCAT_PROBE_H

#include <stdbool.h>
#include <stdint.h>

#include "application.h"

#define PROBE_ON 0x0101u /* either one, in 60B8 */

struct probe {
  uint16_t function;      /* 60B8 as it was */
  uint8_t source[PROBES]; /* as it was: 0 while the probe is off, otherwise as 60D0 counts them */
  uint16_t index_count;
};

/* The inputs of the device, once in a control cycle, before the axes. */
void probe_inputs(const struct feedback *feedback);
/* Whether 60B8 with these sources (60D0) asks for what is there. */
bool probe_valid(uint16_t function, const int16_t *sources);
/* Whether probe_cycle has anything to do. */
static inline bool probe_active(const struct probe *probe, const struct axis_objects *o) {
  return (probe->function | o->probe_function) & PROBE_ON;
}
/* One control cycle. before: the position a cycle ago, raw; home: of the master's positions over raw ones. */
void probe_cycle(struct probe *probe, struct axis_objects *o, const struct axis_feedback *feedback, int32_t before,
                 int32_t home);

#endif
