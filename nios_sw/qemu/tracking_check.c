/* SPDX-License-Identifier: Apache-2.0 */
/* The tracking law in soft float under QEMU: reads from the file tracking.in the robot (struct
 * tracking_parameters), then ticks (struct tick_input each), writes tracking.out (14 floats each:
 * desired l, v, a of the legs, then the outputs). */
#include <fcntl.h>
#include <unistd.h>

#include "tracking.h"

int main(void) {
  static struct tick_input in;
  static struct {
    struct joint_motion desired;
    struct tick_output out;
  } row;
  int source = open("tracking.in", O_RDONLY);
  int sink = open("tracking.out", O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (source < 0 || sink < 0) return 1;
  if (read(source, &tracking_parameters, sizeof tracking_parameters) != sizeof tracking_parameters)
    return 1;
  for (int tick = 0; read(source, &in, sizeof in) == sizeof in; ++tick) {
    if (tick == 0) tracking_start(&in);
    tracking_tick(&in, &row.out);
    row.desired = tracking_desired;
    if (write(sink, &row, sizeof row) != sizeof row) return 2;
  }
  return 0;
}
