/* SPDX-License-Identifier: Apache-2.0 */
/* Where the slave controller is on the Nios II system, and its SII image (gen/sii.c). */
#ifndef ETHERCAT_ESC_NIOS_H
#define ETHERCAT_ESC_NIOS_H

#include <stdint.h>

#include "esc.h"
#include "gen/objects.h"

#define SII_IMAGE 0x8000u /* in the controller, rtl/ethercat/regmap.rdl */
#define SII_RELOAD 0x0400u

extern const uint8_t sii_image[];
extern const uint16_t sii_bytes;

/* Fills the image and has the controller load it. */
void esc_load_image(void);

#endif
