/* SPDX-License-Identifier: Apache-2.0 */
/* Firmware images in flash: two places, of which one has the present image and the other takes the next one. An image
 * counts when its last write, the record at the start of its place, is done; until then the former one is the
 * present one. A boot loader of a product uses image_start and image_current.
 *
 * A file: "MTFW", product code (1018:02), bytes of the content, CRC-32 of the content, each a little-endian word of
 * 32 bits; then the content. sim/bus/coe/firmware.py makes one. */
#ifndef ETHERCAT_IMAGE_H
#define ETHERCAT_IMAGE_H

#include <stdbool.h>
#include <stdint.h>

#define IMAGE_CHUNK 248u /* bytes at most that come at once */
#define IMAGE_WORKING 1u /* image_work has not ended yet */

/* Finds the present image: check sums of all that is there. */
void image_start(void);
/* The next image begins; what came of one before is void. */
void image_begin(void);
/* Bytes of the file, in their order, after image_work has ended; all but the last a multiple of 4. */
void image_append(const uint8_t *data, uint16_t bytes, bool last);
/* Some of the work: IMAGE_WORKING, 0 when it has ended, or the error code of FoE. */
uint16_t image_work(void);
/* Where the file of the present image is in flash; false: there is none. */
bool image_current(uint32_t *at, uint32_t *bytes);

#endif
