/* SPDX-License-Identifier: Apache-2.0 */
/* Touch probe, see probe.h. */
#include "probe.h"

/* Bits of 60B8, of the first probe; the second one has them 8 bits higher. In 60B9 bit 0 is the same, bits 1 and 2 are
 * set with a value of a rising and of a falling edge. */
#define ON 0x01u
#define CONTINUOUS 0x02u
#define SOURCE 0x0Cu
#define SOURCE_INDEX 0x04u
#define RISING 0x10u
#define FALLING 0x20u
#define RESERVED 0xC0u
#define FIRST 0xFFu /* the bits of probe 1; those of probe 2 from SECOND on */
#define SECOND 8
#define STORED 0x02u /* shifted by the edge */

static struct {
  uint8_t level, changed;
  uint16_t age[PROBES]; /* of the last edge, 1/65536 of a control cycle */
} inputs;

void probe_inputs(const struct feedback *feedback) {
  inputs.changed = inputs.level ^ feedback->digital_inputs;
  inputs.level = feedback->digital_inputs;
  for (int n = 0; inputs.changed && n < PROBES; ++n) inputs.age[n] = feedback->edge_age[n];
}

static bool valid(uint16_t function) {
  uint16_t source = function & SOURCE;
  if (function & RESERVED) return false;
  return source == 0 || (source == SOURCE_INDEX && !(function & FALLING));
}

bool probe_valid(uint16_t function) {
  bool first = !(function & ON) || valid(function);
  return first && (!(function >> 8 & ON) || valid(function >> 8));
}

/* Of the input, at its edge. */
static int32_t place_of(const struct axis_feedback *feedback, int n, int32_t before) {
  float way = (float)(int32_t)((uint32_t)feedback->position - (uint32_t)before);
  float back = way * (float)inputs.age[n] * (1.0f / 65536.0f);
  int32_t whole = (int32_t)(back < 0.0f ? back - 0.5f : back + 0.5f);
  return (int32_t)((uint32_t)feedback->position - (uint32_t)whole);
}

/* Status of one probe, whose function was `was`. */
static uint16_t one(const struct probe *probe, struct axis_objects *o, const struct axis_feedback *feedback, int n,
                    uint16_t status, int32_t before, int32_t home) {
  uint16_t now = o->probe_function >> 8 * n, was = probe->function >> 8 * n;
  bool index = (now & SOURCE) == SOURCE_INDEX, begins;
  int32_t place;
  uint8_t changed = inputs.changed >> n & 1u, falls = !(inputs.level >> n & 1u);
  if (!(now & ON) || !valid(now)) return 0;
  begins = !(was & ON) || !valid(was) || (now & SOURCE) != (was & SOURCE);
  if (begins) {
    o->probe_count[2 * n] = o->probe_count[2 * n + 1] = 0;
    return ON; /* edges count from the next cycle on */
  }
  for (int edge = 0; edge < 2; ++edge) {
    uint16_t stored = (uint16_t)(STORED << edge);
    if (!(now & RISING << edge)) {
      status &= (uint16_t)~stored;
      continue;
    }
    if (status & stored && !(now & CONTINUOUS)) continue;
    if (index ? feedback->index_count == probe->index_count : !changed || falls != edge) continue;
    place = index ? feedback->index_position : place_of(feedback, n, before);
    o->probe_value[2 * n + edge] = (int32_t)((uint32_t)place + (uint32_t)home);
    ++o->probe_count[2 * n + edge];
    status |= stored;
  }
  return status | ON;
}

void probe_cycle(struct probe *probe, struct axis_objects *o, const struct axis_feedback *feedback, int32_t before,
                 int32_t home) {
  uint16_t was = o->probe_status;
  uint16_t first = one(probe, o, feedback, 0, was & FIRST, before, home);
  uint16_t second = one(probe, o, feedback, 1, was >> SECOND, before, home);
  o->probe_status = (uint16_t)(first | second << SECOND);
  probe->function = o->probe_function;
  probe->index_count = feedback->index_count;
}
