/* SPDX-License-Identifier: Apache-2.0 */
/* Bus of a Verilated core, for C programs that run against the RTL: functions of an asip_bus,
 * context unused. The core is reset at the first access; its clock runs during accesses only. An
 * access that is never answered ends the process with status 3. */
#ifndef SIM_BUS_H
#define SIM_BUS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

uint32_t sim_read32(void *context, uint32_t address);
void sim_write32(void *context, uint32_t address, uint32_t data);

/* Level of the interrupt. */
int sim_irq(void);

#ifdef __cplusplus
}
#endif

#endif
