/* SPDX-License-Identifier: Apache-2.0 */
/* Touch probe, see probe.h. */
#include "probe.h"

/* Bits of 60B8, of the first probe; the second one has them 8 bits higher. In 60B9 bit 0 is the same, bits 1 and 2 are
 * set with a value of a rising and of a falling edge. */
#define ON 0x01u
#define CONTINUOUS 0x02u
#define SOURCE_INDEX 0x04u
#define SOURCE_OBJECT 0x08u /* 60D0 */
#define RISING 0x10u
#define FALLING 0x20u
#define RESERVED 0xC0u
#define FIRST 0xFFu /* the bits of probe 1; those of probe 2 from SECOND on */
#define SECOND 8
#define STORED 0x02u /* shifted by the edge */
#define INDEX 3u     /* in 60D0; 1 and 2 are inputs */

static struct {
  uint8_t level, changed;
  uint16_t age[PROBES]; /* of the last edge, 1/65536 of a control cycle */
} inputs;

void probe_inputs(const struct feedback *feedback) {
  inputs.changed = inputs.level ^ feedback->digital_inputs;
  inputs.level = feedback->digital_inputs;
  for (int n = 0; inputs.changed && n < PROBES; ++n) inputs.age[n] = feedback->edge_age[n];
}

/* Of probe n by its bits of 60B8, as 60D0 counts; 0: the probe is off, or asks for what is not there. */
static uint8_t source_of(uint16_t function, int n, const int16_t *sources) {
  uint8_t source = (uint8_t)(n + 1);
  if (!(function & ON) || function & RESERVED) return 0;
  if (function & SOURCE_INDEX) source = INDEX;
  if (function & SOURCE_OBJECT) source = function & SOURCE_INDEX ? 0 : (uint8_t)sources[n];
  return source == INDEX && function & FALLING ? 0 : source;
}

bool probe_valid(uint16_t function, const int16_t *sources) {
  for (int n = 0; n < PROBES; ++n) {
    uint16_t own = function >> SECOND * n;
    if (own & ON && !source_of(own, n, sources)) return false;
  }
  return true;
}

/* Of input n, at its edge. */
static int32_t place_of(const struct axis_feedback *feedback, int n, int32_t before) {
  float way = (float)(int32_t)((uint32_t)feedback->position - (uint32_t)before);
  float back = way * (float)inputs.age[n] * (1.0f / 65536.0f);
  int32_t whole = (int32_t)(back < 0.0f ? back - 0.5f : back + 0.5f);
  return (int32_t)((uint32_t)feedback->position - (uint32_t)whole);
}

/* Status of one probe. */
static uint16_t one(struct probe *probe, struct axis_objects *o, const struct axis_feedback *feedback, int n,
                    uint16_t status, int32_t before, int32_t home) {
  uint16_t now = o->probe_function >> SECOND * n;
  uint8_t source = source_of(now, n, o->probe_source), was = probe->source[n], input, changed, falls;
  bool index = source == INDEX;
  int32_t place;
  probe->source[n] = source;
  if (!source) return 0;
  input = index ? 0 : source - 1u;
  changed = inputs.changed >> input & 1u;
  falls = !(inputs.level >> input & 1u);
  if (source != was) {
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
    place = index ? feedback->index_position : place_of(feedback, input, before);
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
