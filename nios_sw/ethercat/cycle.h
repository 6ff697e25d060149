/* SPDX-License-Identifier: Apache-2.0 */
/* The control cycle of the device, CYCLE_100NS of the dictionary or of the compiler's command line, in other units. The
 * machine's tick has this period (parameter Period of ethercat_nios). A millisecond is a whole number of cycles. */
#ifndef ETHERCAT_CYCLE_H
#define ETHERCAT_CYCLE_H

#include "gen/objects.h"

#define CYCLE_NS (CYCLE_100NS * 100u)
#define CYCLE_S ((float)(CYCLE_100NS * 1e-7))
#define CYCLES_PER_S (1e7f / CYCLE_100NS)
#define CYCLES_PER_MS (10000u / CYCLE_100NS)

_Static_assert(10000u % CYCLE_100NS == 0, "a millisecond has to be a whole number of control cycles");

#endif
