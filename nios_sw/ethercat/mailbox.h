/* SPDX-License-Identifier: Apache-2.0 */
/* Mailbox (ETG.1000.4): messages from the master by SM0, to the master by SM1, repeated on request. */
#ifndef ETHERCAT_MAILBOX_H
#define ETHERCAT_MAILBOX_H

#include <stdbool.h>
#include <stdint.h>

#include "gen/objects.h"

#define MAILBOX_HEADER 6
#define MAILBOX_DATA (MAILBOX_BYTES - MAILBOX_HEADER)
#define MAILBOX_ERROR 0
#define MAILBOX_COE 3
#define MAILBOX_FOE 4

void mailbox_start(void);
void mailbox_stop(void);
/* Once in a while: takes at most one message and answers it, sends at most one; now_ms: rising time. In BOOT the only
 * protocol is FoE. */
void mailbox_step(uint32_t now_ms);
/* Sends now; false if the mailbox is full. */
bool mailbox_send(uint8_t type, const uint8_t *data, uint16_t bytes);

#endif
