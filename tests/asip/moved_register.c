/* SPDX-License-Identifier: Apache-2.0 */
/* One tick of leg_length.s by the C driver, over a bus that the caller gives. */
#include "asip.h"
#include "leg_length.asip.h"

/* Result of asip_tick; `done` gets what asip_status says after it. */
int tick_by_driver(asip_bus bus, const uint32_t *inputs, uint32_t *outputs, int *done) {
  asip core = {bus, NULL};
  asip_result result = asip_load(&core, &leg_length_image);
  if (result == ASIP_OK) result = asip_tick(&core, inputs, outputs, 1000);
  *done = asip_status(&core).done;
  return (int)result;
}
