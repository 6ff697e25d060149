/* SPDX-License-Identifier: Apache-2.0 */
/* Driver demonstration: loads leg_length.s and runs ticks, one per argument "x,y,z,count". A tick
 * prints its outputs, export and cycles. A fault prints its cause, bundle or output and the safe
 * outputs; it is then cleared and the states start again. Exit status: 1 if there is no core, the
 * image does not fit or a run does not end. On a board asip_memory_bus replaces the simulation. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "asip.h"
#include "leg_length.asip.h"
#include "sim_bus.h"

#define POLLS 1000

static void print_outputs(const uint32_t *out) {
  int i;
  for (i = 0; i < LEG_LENGTH_OUTPUTS; i++) {
    printf(" 0x%08" PRIx32 " %.9g", out[i], (double)asip_float(out[i]));
  }
}

static int tick(const asip *core, const char *text) {
  uint32_t in[LEG_LENGTH_INPUTS] = {0}, out[LEG_LENGTH_OUTPUTS];
  asip_result result;
  asip_state state;
  char *end;
  int i;

  for (i = 0; i <= LEG_LENGTH_INPUT_Z; i++) {
    in[i] = asip_word(strtof(text, &end));
    text = *end == ',' ? end + 1 : end;
  }
  in[LEG_LENGTH_INPUT_COUNTER] = (uint32_t)strtol(text, NULL, 10);

  result = asip_tick(core, in, out, POLLS);
  if (result != ASIP_OK && result != ASIP_FAULTED) {
    printf("%s\n", asip_result_text(result));
    return 1;
  }
  state = asip_status(core);
  if (result == ASIP_FAULTED) {
    printf("fault %d, %s, info %" PRIu32 ":", (int)state.cause, asip_fault_text(state.cause),
           state.info);
    print_outputs(out);
    asip_clear(core);
    asip_preset_states(core);
  } else {
    printf("done:");
    print_outputs(out);
    printf(" 0x%08" PRIx32, asip_read_export(core, LEG_LENGTH_EXPORT_SQUARE));
  }
  printf(" cycles %" PRIu32 "\n", state.cycles);
  return 0;
}

int main(int argc, char **argv) {
  asip core = {{sim_read32, sim_write32, NULL}, NULL};
  asip_result result = asip_load(&core, &leg_length_image);
  int i;

  if (result != ASIP_OK) {
    printf("%s\n", asip_result_text(result));
    return 1;
  }
  for (i = 1; i < argc; i++) {
    if (tick(&core, argv[i])) return 1;
  }
  return 0;
}
