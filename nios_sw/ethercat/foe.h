/* SPDX-License-Identifier: Apache-2.0 */
/* File access over EtherCAT (ETG.1000.6 5.8): the server. One transfer at a time; a new request ends the one before. */
#ifndef ETHERCAT_FOE_H
#define ETHERCAT_FOE_H

#include <stdbool.h>
#include <stdint.h>

#define FOE_HEADER 6

/* Error codes. */
#define FOE_NOT_FOUND 0x8001u
#define FOE_DISK_FULL 0x8003u
#define FOE_ILLEGAL 0x8004u
#define FOE_WRONG_PACKET 0x8005u
#define FOE_BOOTSTRAP_ONLY 0x8008u
#define FOE_NO_RIGHTS 0x800Au
#define FOE_WRONG_SUM 0x800Cu
#define FOE_WRONG_DEVICE 0x800Du
#define FOE_NO_FILE 0x800Fu
#define FOE_NO_HEADER 0x8010u
#define FOE_FLASH 0x8011u

void foe_start(void);
/* A message: header and data, FOE_HEADER bytes at least. */
void foe_request(const uint8_t *data, uint16_t bytes, uint32_t now_ms);
/* Goes on with what a request began, by at most one message; whether it sent one. */
bool foe_continue(uint32_t now_ms);

#endif
