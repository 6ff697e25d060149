/* SPDX-License-Identifier: Apache-2.0 */
/* CoreMark on the Nios II systems: seeds of the run that results are compared by, and time. */
#include "coremark.h"
#include "io.h"

#ifndef ITERATIONS
#define ITERATIONS 10
#endif

volatile ee_s32 seed1_volatile = 0;
volatile ee_s32 seed2_volatile = 0;
volatile ee_s32 seed3_volatile = 0x66;
volatile ee_s32 seed4_volatile = ITERATIONS;
volatile ee_s32 seed5_volatile = 0;

ee_u32 default_num_contexts = 1;

static uint32_t begin, end;

void start_time(void) { begin = cycle_now(); }
void stop_time(void) { end = cycle_now(); }
CORE_TICKS get_time(void) { return end - begin; }
secs_ret time_in_secs(CORE_TICKS ticks) { return ticks / 100000000u; }

void portable_init(core_portable *port, int *argc, char *argv[]) {
  (void)argc;
  (void)argv;
  port->portable_id = 1;
}

void portable_fini(core_portable *port) { port->portable_id = 0; }
