/* SPDX-License-Identifier: Apache-2.0 */
/* Stored parameters (CiA 301, 1010 and 1011): the entries that dictionary.toml marks `stored`, in two sectors of the
 * flash, of which one has the present values. They are loaded at power up. */
#ifndef ETHERCAT_PARAMETERS_H
#define ETHERCAT_PARAMETERS_H

#include <stdbool.h>
#include <stdint.h>

#define PARAMETERS_SAVE 0x1010u /* objects */
#define PARAMETERS_LOAD 0x1011u

/* Object 2022. */
#define PARAMETERS_NONE 0    /* nothing was stored: defaults */
#define PARAMETERS_LOADED 1
#define PARAMETERS_DAMAGED 2 /* defaults */
#define PARAMETERS_FORMER 3  /* the last ones are damaged, those stored before were loaded */
#define PARAMETERS_PARTLY 4  /* some are not allowed any more: those are defaults */

enum parameters { PARAMETERS_IDLE, PARAMETERS_WORKING, PARAMETERS_FAILED };

/* Loads what is stored; the objects have their defaults. */
void parameters_start(void);
/* A write to subindex 1 of 1010 or 1011: the work begins. 0 or the abort code of an SDO. */
uint32_t parameters_command(uint16_t index, uint32_t signature);
/* Some of the work, from the background. */
void parameters_work(void);
enum parameters parameters_state(void);

#endif
