/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-32 of IEEE 802.3, as zlib's crc32: polynomial 04C11DB7, reflected. */
#ifndef ETHERCAT_CRC32_H
#define ETHERCAT_CRC32_H

#include <stdint.h>

/* Continues the check sum `crc` of what came before, 0 at the start. */
uint32_t crc32(uint32_t crc, const void *data, uint32_t bytes);

#endif
