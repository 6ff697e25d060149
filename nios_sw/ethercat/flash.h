/* SPDX-License-Identifier: Apache-2.0 */
/* Flash memory of the device, seen from the application. A product connects its part here: flash_nios.c is memory of
 * the reference system, which has no flash, tests/ethercat/flash_double.c is the double of the tests.
 *
 * Erased bytes are 0xFF. A write clears bits only. An erase and a write begin and return at once: the background asks
 * flash_state until they end, so that neither the control pass nor the mailbox waits for them. */
#ifndef ETHERCAT_FLASH_H
#define ETHERCAT_FLASH_H

#include <stdbool.h>
#include <stdint.h>

#define FLASH_SECTOR 2048u /* bytes that an erase clears */
#ifndef FLASH_IMAGE_BYTES
#define FLASH_IMAGE_BYTES 8192u /* of one of two firmware images, whole sectors; a product sets what its flash has */
#endif
#define FLASH_IMAGE(n) ((n) * FLASH_IMAGE_BYTES)
#define FLASH_STORE(n) (FLASH_IMAGE(2u) + (n) * FLASH_SECTOR) /* two places of stored parameters */
#define FLASH_BYTES FLASH_STORE(2u)

/* Whether the content outlives power off; if not, parameters are not stored (1010). */
extern const bool flash_lasts;

enum flash_state { FLASH_READY, FLASH_BUSY, FLASH_FAILED };

/* Begins to erase the sector at `at`, a multiple of FLASH_SECTOR. Only while the state is not FLASH_BUSY. */
void flash_erase(uint32_t at);
/* Begins to write; `at` and `bytes` are multiples of 4, `from` stays as it is until the end. Only while the state is
 * not FLASH_BUSY. */
void flash_write(uint32_t at, const void *from, uint32_t bytes);
/* Of the last erase or write: under way, ended well, or failed. */
enum flash_state flash_state(void);
/* Only while the state is not FLASH_BUSY. */
void flash_read(uint32_t at, void *to, uint32_t bytes);

#endif
