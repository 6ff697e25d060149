/* SPDX-License-Identifier: Apache-2.0 */
/* Two functions of one image by the driver (test_functions.py): five ticks of `fast` for each of `slow`;
 * prints what each reads, and `fast` again from its initial state. */
#include <inttypes.h>
#include <stdio.h>

#include "asip.h"
#include "both.asip.h"
#include "sim_bus.h"

#define POLLS 1000

static uint32_t tick(const asip *core, const asip_function *function, uint32_t word) {
  uint32_t out = 0;
  if (asip_function_tick(core, function, &word, &out, POLLS) != ASIP_OK) printf("fault\n");
  return out;
}

int main(void) {
  asip core = {{sim_read32, sim_write32, NULL}, NULL};
  int i, k;

  if (asip_load(&core, &both_image) != ASIP_OK) return 1;
  for (i = 0; i < 3; i++) {
    for (k = 0; k < 5; k++) printf("%g ", (double)asip_float(tick(&core, &both_fast, asip_word(0.5f))));
    printf("| %g\n", (double)asip_float(tick(&core, &both_slow, 3)));
  }
  asip_preset_function(&core, &both_fast);
  printf("%g | %g\n", (double)asip_float(tick(&core, &both_fast, asip_word(0.5f))),
         (double)asip_float(tick(&core, &both_slow, 1)));
  return BOTH_FAST_INPUTS == 1 && BOTH_SLOW_OUTPUT_PRODUCT_OUT == 0 ? 0 : 2;
}
