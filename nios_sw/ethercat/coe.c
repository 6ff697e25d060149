/* SPDX-License-Identifier: Apache-2.0 */
/* CANopen over EtherCAT, see coe.h. */
#include "coe.h"

#include "diagnosis.h"
#include "dictionary.h"
#include "mailbox.h"

#define QUEUE 8

static struct {
  uint16_t code;
  uint8_t axis, error_register;
} queue[QUEUE];
static uint8_t queue_put, queue_sent; /* rising: one is the control pass', one the background's */

void coe_start(void) {
  queue_put = queue_sent = 0;
  sdo_start();
  sdo_information_start();
}

void coe_emergency(uint16_t code, uint8_t axis) {
  uint8_t last = queue_put % QUEUE;
  if (code) diagnosis_note(DIAGNOSIS_AXIS_ERROR, code, (uint8_t)(axis + 1u));
  if ((uint8_t)(queue_put - queue_sent) == QUEUE) return;
  queue[last].code = code;
  queue[last].axis = axis;
  queue[last].error_register = objects.error_register;
  ++queue_put;
}

bool coe_continue(void) {
  if (sdo_continue() || sdo_information_continue()) return true;
  if (queue_put != queue_sent) {
    uint8_t first = queue_sent % QUEUE;
    const uint8_t message[10] = {0, COE_EMERGENCY << 4, (uint8_t)queue[first].code,
                                 (uint8_t)(queue[first].code >> 8), queue[first].error_register,
                                 queue[first].axis};
    if (mailbox_send(MAILBOX_COE, message, sizeof message)) ++queue_sent;
    return true;
  }
  return false;
}

void coe_request(const uint8_t *data, uint16_t bytes) {
  uint8_t service = data[1] >> 4;
  if (service == COE_SDO_REQUEST) {
    sdo_request(data + COE_HEADER, (uint16_t)(bytes - COE_HEADER));
  } else if (service == COE_SDO_INFORMATION) {
    sdo_information_request(data + COE_HEADER, (uint16_t)(bytes - COE_HEADER));
  } else {
    const uint8_t answer[4] = {1, 0, 4, 0}; /* service not supported */
    mailbox_send(MAILBOX_ERROR, answer, sizeof answer);
  }
}
