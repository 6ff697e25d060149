/* SPDX-License-Identifier: Apache-2.0 */
/* Application layer state machine (ETG.1000.6): what the master asks for in AL_CONTROL is checked step by
 * step; AL_STATUS and AL_STATUS_CODE answer. Explicit device identification: while AL_CONTROL has bit 5 and there
 * is no error, AL_STATUS has bit 5 and AL_STATUS_CODE is object 2021. */
#ifndef ETHERCAT_AL_H
#define ETHERCAT_AL_H

#include <stdbool.h>
#include <stdint.h>

#define SYNC0 2 /* in 1C32:01 */
#define AL_INIT 1
#define AL_PREOP 2
#define AL_BOOT 3
#define AL_SAFEOP 4
#define AL_OP 8

#define AL_INVALID_CHANGE 0x0011
#define AL_UNKNOWN_STATE 0x0012
#define AL_INVALID_BOOT_MAILBOX 0x0015
#define AL_INVALID_MAILBOX 0x0016
#define AL_INVALID_SYNC_MANAGER 0x0017
#define AL_NO_OUTPUTS 0x0019
#define AL_SYNC_ERROR 0x001A
#define AL_WATCHDOG 0x001B
#define AL_INVALID_OUTPUTS 0x001D
#define AL_INVALID_INPUTS 0x001E
#define AL_OUTPUT_MAPPING 0x0025
#define AL_SYNC_LOST 0x002C
#define AL_NO_SYNC 0x002D
#define AL_INVALID_SYNC 0x0030
#define AL_INVALID_CYCLE 0x0035
#define AL_WRONG_PERIOD 0x8001 /* of the machine's tick; codes from 0x8000 on are the vendor's */

void al_start(void);
extern uint8_t al_present; /* the state; al.c alone writes it */
static inline uint8_t al_state(void) { return al_present; }
uint16_t al_code(void);
/* Once in a while: answers a request, and watches the sync managers; now_ms: rising time. */
void al_step(uint32_t now_ms);
/* The outputs were written by the master (valid outputs for OP). */
void al_outputs_seen(void);
/* SYNC0 has pulsed (for OP, where 1C32 asks for it). */
void al_sync0_seen(void);
/* A fault of the device: from OP to SAFEOP with the code. */
void al_fault(uint16_t code);
/* A fault for good: INIT, and each other state but BOOT is refused with the code. */
void al_halt(uint16_t code);
/* The cycle of SYNC0 [ns]; whether it is as 1C32 wants it. */
bool al_clock_holds(uint32_t *cycle);
/* Bytes of the process data of a direction, as mapped when SAFEOP was entered. */
uint16_t al_process_bytes(int side);

#endif
