/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of the driver's paths off the good run; argument 1 names the check. Prints what fails. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "asip.h"
#include "endless.asip.h"
#include "other.asip.h"
#include "record.asip.h"
#include "table.asip.h"
#include "sim_bus.h"

#define EXPECT(condition)                                     \
  if (!(condition)) {                                         \
    printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);    \
    return 1;                                                 \
  }

static const uint32_t forever[] = {1}, never[] = {0};
static unsigned writes;

static uint32_t zero_read32(void *context, uint32_t address) {
  (void)context;
  return 0 * address;
}

static void counting_write32(void *context, uint32_t address, uint32_t data) {
  writes++;
  sim_write32(context, address, data);
}

static int lost; /* reads of STATUS in a run whose bits are lost on their way */

static uint32_t losing_read32(void *context, uint32_t address) {
  const uint32_t word = sim_read32(context, address);
  if (address == ASIP_WORD(csr.STATUS) && lost && word & ASIP__CSR__STATUS__BUSY_bm) return lost--, 0;
  return word;
}

static int check_absent(void) {
  asip core = {{zero_read32, counting_write32, NULL}, NULL};
  EXPECT(asip_check_id(&core) == ASIP_NO_CORE);
  EXPECT(asip_load(&core, &endless_image) == ASIP_NO_CORE);
  EXPECT(writes == 0);
  return 0;
}

static int check_wrong(void) {
  asip core = {{sim_read32, counting_write32, NULL}, NULL};
  asip_image large = endless_image;
  EXPECT(asip_load(&core, &other_image) == ASIP_WRONG_CORE);
  large.bundles = 1025;
  EXPECT(asip_load(&core, &large) == ASIP_WRONG_CORE);
  large = endless_image;
  large.data_words = 1025;
  EXPECT(asip_load(&core, &large) == ASIP_WRONG_CORE);
  EXPECT(writes == 0);
  return 0;
}

static int check_timeout(void) {
  asip core = {{sim_read32, counting_write32, NULL}, NULL};
  uint32_t out[ENDLESS_OUTPUTS];
  unsigned before;
  asip_state state;
  EXPECT(asip_load(&core, &endless_image) == ASIP_OK);
  EXPECT(asip_wait(&core, 0) == ASIP_TIMEOUT);
  EXPECT(asip_wait(&core, 1) == ASIP_NOT_STARTED);
  asip_set_inputs(&core, forever);
  asip_start(&core);
  EXPECT(asip_wait(&core, 20) == ASIP_TIMEOUT);
  EXPECT(asip_status(&core).busy);
  before = writes;
  EXPECT(asip_load(&core, &endless_image) == ASIP_BUSY);
  EXPECT(writes == before);
  asip_clear(&core);
  EXPECT(asip_wait(&core, 20) == ASIP_TIMEOUT);
  EXPECT(asip_wait(&core, 2000) == ASIP_FAULTED);
  state = asip_status(&core);
  EXPECT(!state.busy && !state.done && state.faulted && state.cause == ASIP_FAULT_WATCHDOG);
  EXPECT(strcmp(asip_fault_text(state.cause), "run longer than WATCHDOG cycles") == 0);
  EXPECT(state.cycles >= endless_image.watchdog);
  asip_read_outputs(&core, out);
  EXPECT(asip_float(out[0]) == 1.5f);
  asip_set_inputs(&core, never);
  asip_start(&core); /* ignored: the fault is latched */
  EXPECT(asip_wait(&core, 100) == ASIP_FAULTED);
  asip_clear(&core);
  EXPECT(asip_wait(&core, 1) == ASIP_NOT_STARTED);
  asip_start(&core);
  EXPECT(asip_wait(&core, 100) == ASIP_OK);
  asip_read_outputs(&core, out);
  EXPECT(out[0] == 0);
  return 0;
}

static int check_interrupt(void) {
  asip core = {{sim_read32, sim_write32, NULL}, NULL};
  EXPECT(asip_load(&core, &endless_image) == ASIP_OK);
  asip_set_inputs(&core, never);
  asip_enable_interrupts(&core, 1, 0);
  EXPECT(!sim_irq());
  asip_start(&core);
  EXPECT(asip_wait(&core, 100) == ASIP_OK && sim_irq());
  asip_clear(&core);
  EXPECT(!sim_irq());
  asip_set_inputs(&core, forever);
  asip_start(&core);
  EXPECT(asip_wait(&core, 2000) == ASIP_FAULTED && !sim_irq());
  asip_enable_interrupts(&core, 0, 1);
  EXPECT(sim_irq());
  asip_clear(&core);
  EXPECT(!sim_irq());
  return 0;
}

static int check_no_record(void) {
  asip core = {{sim_read32, counting_write32, NULL}, NULL};
  EXPECT(asip_set_plausible(&core, 0, 0.0f, 1.0f, 1.0f) == ASIP_NO_RECORD);
  EXPECT(asip_end_plausible(&core, 0) == ASIP_NO_RECORD);
  EXPECT(writes == 0);
  return 0;
}

static int check_plausible(void) {
  asip core = {{sim_read32, counting_write32, NULL}, NULL};
  uint32_t in[RECORD_INPUTS], out[RECORD_OUTPUTS];
  unsigned before;
  asip_state state;
  EXPECT(asip_load(&core, &record_image) == ASIP_OK);
  before = writes;
  EXPECT(asip_set_plausible(&core, ASIP_RECORDS, 0.0f, 1.0f, 1.0f) == ASIP_NO_RECORD);
  EXPECT(asip_end_plausible(&core, ASIP_RECORDS) == ASIP_NO_RECORD);
  EXPECT(asip_set_plausible(&core, 0, 1.0f, 0.5f, 1.0f) == ASIP_BAD_RECORD);
  EXPECT(asip_set_plausible(&core, 0, 0.0f, 1.0f, -1.0f) == ASIP_BAD_RECORD);
  EXPECT(asip_set_plausible(&core, 0, NAN, 1.0f, 1.0f) == ASIP_BAD_RECORD);
  EXPECT(asip_set_plausible(&core, 0, 0.0f, NAN, 1.0f) == ASIP_BAD_RECORD);
  EXPECT(asip_set_plausible(&core, 0, 0.0f, 1.0f, NAN) == ASIP_BAD_RECORD);
  EXPECT(writes == before);

  EXPECT(asip_set_plausible(&core, 0, -INFINITY, 10.0f, 0.5f) == ASIP_OK);
  in[0] = asip_word(9.0f);
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_OK && asip_float(out[0]) == 9.0f);
  in[0] = asip_word(9.5f);
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_OK && asip_float(out[0]) == 9.5f);
  in[0] = asip_word(8.5f);
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_FAULTED && asip_float(out[0]) == 1.5f);
  state = asip_status(&core);
  EXPECT(state.faulted && state.cause == ASIP_FAULT_IMPLAUSIBLE && state.info == 0);
  asip_clear(&core);
  in[0] = asip_word(11.0f);
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_FAULTED && asip_float(out[0]) == 1.5f);
  asip_clear(&core);
  EXPECT(asip_end_plausible(&core, 0) == ASIP_OK);
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_OK && asip_float(out[0]) == 11.0f);
  core.bus.read32 = losing_read32;
  in[0] = asip_word(12.0f);
  lost = 1;
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_OK && asip_float(out[0]) == 12.0f);
  EXPECT(lost == 0);
  lost = 2;
  EXPECT(asip_checked_tick(&core, in, out, 1000) == ASIP_NOT_STARTED);
  return 0;
}

static int check_data(void) {
  asip core = {{sim_read32, counting_write32, NULL}, NULL};
  const uint32_t in[TABLE_INPUTS] = {1}, words[2] = {asip_word(20.0f), asip_word(30.0f)};
  uint32_t out[TABLE_OUTPUTS];
  unsigned before;
  EXPECT(asip_load(&core, &table_image) == ASIP_OK);
  EXPECT(asip_tick(&core, in, out, 1000) == ASIP_OK && asip_float(out[0]) == 2.0f);
  before = writes;
  asip_preset_data(&core, 1, words, 2);
  EXPECT(writes == before + 2);
  EXPECT(asip_tick(&core, in, out, 1000) == ASIP_OK && asip_float(out[0]) == 20.0f);
  return 0;
}

static int check_memory_bus(void) {
  uint32_t memory[16] = {ASIP__CSR__ID__VALUE_reset};
  asip core = {asip_memory_bus(memory), NULL};
  EXPECT(asip_check_id(&core) == ASIP_OK);
  asip_start(&core);
  EXPECT(memory[ASIP_WORD(csr.CONTROL)] == ASIP__CSR__CONTROL__START_bm);
  memory[ASIP_WORD(csr.ID)]++;
  EXPECT(asip_check_id(&core) == ASIP_NO_CORE);
  return 0;
}

int main(int argc, char **argv) {
  const char *name = argc > 1 ? argv[1] : "";
  if (!strcmp(name, "absent")) return check_absent();
  if (!strcmp(name, "wrong")) return check_wrong();
  if (!strcmp(name, "timeout")) return check_timeout();
  if (!strcmp(name, "interrupt")) return check_interrupt();
  if (!strcmp(name, "no_record")) return check_no_record();
  if (!strcmp(name, "plausible")) return check_plausible();
  if (!strcmp(name, "data")) return check_data();
  if (!strcmp(name, "memory_bus")) return check_memory_bus();
  printf("no check '%s'\n", name);
  return 2;
}
