/* SPDX-License-Identifier: Apache-2.0 */
/* CANopen over EtherCAT (ETG.1000.6): SDO server, SDO information, emergencies. */
#ifndef ETHERCAT_COE_H
#define ETHERCAT_COE_H

#include <stdbool.h>
#include <stdint.h>

#define COE_HEADER 2
#define COE_EMERGENCY 1
#define COE_SDO_REQUEST 2
#define COE_SDO_RESPONSE 3
#define COE_SDO_INFORMATION 8

void coe_start(void);
/* A CoE message: header and data; answers by mailbox_send. */
void coe_request(const uint8_t *data, uint16_t bytes);
/* Sends what waits: the rest of a list, an emergency; whether it sent something. */
bool coe_continue(void);
/* Puts an emergency into the queue of eight; error code of CiA 402, axis 0.. or 0xFF. The newest is
 * dropped when the queue is full. */
void coe_emergency(uint16_t code, uint8_t axis);

/* sdo.c, sdo_information.c: `sdo`, 8 bytes at least, is what follows the CoE header. */
void sdo_start(void);
/* Confirms a download when its parameters are stored; whether it sent something. */
bool sdo_continue(void);
void sdo_request(const uint8_t *sdo, uint16_t bytes);
void sdo_information_start(void);
void sdo_information_request(const uint8_t *request, uint16_t bytes);
bool sdo_information_continue(void);

#endif
