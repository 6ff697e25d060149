/* SPDX-License-Identifier: Apache-2.0 */
/* Diagnosis history (object 10F3, ETG.1020): the last messages of the device, with time and parameters. The texts
 * are in dictionary.toml and in the ESI file; a text's number, kind and diagnosis code are in gen/objects.h. */
#ifndef ETHERCAT_DIAGNOSIS_H
#define ETHERCAT_DIAGNOSIS_H

#include <stdint.h>

#define DIAGNOSIS 0x10F3u /* object */

void diagnosis_start(void);
/* A message for the history. From the control pass too: it takes a few instructions. code: a word that the
 * diagnosis code has and that is the first parameter; place: axis or state, the second one. */
void diagnosis_note(uint16_t text, uint16_t code, uint8_t place);
/* Puts what was noted into the history, from the background. */
void diagnosis_work(void);
/* A write to a subindex: 0 or the abort code of an SDO. */
uint32_t diagnosis_write(uint8_t subindex, uint32_t value);
/* A subindex was read. */
void diagnosis_read(uint8_t subindex);

#endif
