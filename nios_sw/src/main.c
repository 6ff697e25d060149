/* SPDX-License-Identifier: Apache-2.0 */
/* The controller program of FPGA1 and FPGA2: one tick of the tracking law for each control tick,
 * from when the host enables it until it stops. It refuses to run without a robot. */
#include "io.h"
#include "tracking.h"

int main(void) {
  const volatile struct tick_input *in = (const volatile struct tick_input *)INPUT_BASE;
  volatile struct tick_output *out = (volatile struct tick_output *)OUTPUT_BASE;

  if (!(tracking_parameters.t_s > 0.0f)) {
    console_text("no robot in tracking_parameters: write it before the start\n");
    return 1;
  }
  while (!(io_read(REG_TICK_STATUS) & TICK_STATUS_ENABLE)) {
  }
  tracking_start(in);
  for (;;) {
    uint32_t status;
    do {
      status = io_read(REG_TICK_STATUS);
    } while ((status & (TICK_STATUS_PENDING | TICK_STATUS_ENABLE)) == TICK_STATUS_ENABLE);
    if (!(status & TICK_STATUS_ENABLE)) return 0;
    tracking_tick(in, out);
    io_write(REG_TICK_DONE, 0);
  }
}
