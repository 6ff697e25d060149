/* SPDX-License-Identifier: Apache-2.0 */
/* A double of the flash for tests on a host: what it does wrong is asked for. */
#ifndef FLASH_DOUBLE_H
#define FLASH_DOUBLE_H

#include <stdint.h>

/* All erased, nothing wrong. */
void flash_double_clear(void);
/* Ends what was under way, as at power on; the content stays. */
void flash_double_power_on(void);
/* Each erase and write lasts until flash_state was asked `polls` times. */
void flash_double_slow(uint32_t polls);
/* The operation after `operations` others fails and does nothing. */
void flash_double_fail_after(uint32_t operations);
/* The power goes in the middle of the operation after `operations` others: half of it is done, the rest never ends. */
void flash_double_cut_after(uint32_t operations);
/* Erases and writes since all was erased. */
uint32_t flash_double_operations(void);
uint8_t *flash_double_content(void);

#endif
