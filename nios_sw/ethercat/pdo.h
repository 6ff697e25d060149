/* SPDX-License-Identifier: Apache-2.0 */
/* Process data: what the objects 1C12, 1C13, 16xx and 1Axx map. Whole bytes only. */
#ifndef ETHERCAT_PDO_H
#define ETHERCAT_PDO_H

#include <stdint.h>

#include "gen/objects.h"

#define PDO_RX 0 /* from the master */
#define PDO_TX 1

/* Abort code for writing `value` to an object of the mapping, 0 for any other object. */
uint32_t pdo_check(uint16_t index, uint8_t subindex, uint32_t value);
#define PDO_INVALID 0xFFFFu
/* Prepares the exchange as mapped now; bytes of the direction, or PDO_INVALID if the master would write an object
 * twice. */
uint16_t pdo_prepare(int side);
/* The process data of a direction, as words. */
extern union pdo_image {
  uint32_t words[PROCESS_BYTES / 4];
  uint8_t bytes[PROCESS_BYTES];
} pdo_image[2];
/* From the image to the objects; from the objects to the image. */
void pdo_outputs(void);
void pdo_inputs(void);

#endif
