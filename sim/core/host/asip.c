/* SPDX-License-Identifier: Apache-2.0 */
#include "asip.h"

#include <string.h>

#define MASK(register, field) ASIP__CSR__##register##__##field##_bm
#define FIELD(value, register, field) \
  (((value) & MASK(register, field)) >> ASIP__CSR__##register##__##field##_bp)
#define CSR(register) ASIP_WORD(csr.register)

static uint32_t read32(const asip *core, uint32_t address) {
  return core->bus.read32(core->bus.context, address);
}

static void write32(const asip *core, uint32_t address, uint32_t data) {
  core->bus.write32(core->bus.context, address, data);
}

static uint32_t memory_read32(void *context, uint32_t address) {
  return ((volatile uint32_t *)context)[address];
}

static void memory_write32(void *context, uint32_t address, uint32_t data) {
  ((volatile uint32_t *)context)[address] = data;
}

asip_bus asip_memory_bus(volatile uint32_t *base) {
  asip_bus bus = {memory_read32, memory_write32, (void *)base};
  return bus;
}

asip_result asip_check_id(const asip *core) {
  return read32(core, CSR(ID)) == ASIP__CSR__ID__VALUE_reset ? ASIP_OK : ASIP_NO_CORE;
}

static int fits(const asip *core, const asip_image *image) {
  const uint32_t config = read32(core, CSR(CONFIG));
  const uint32_t words = FIELD(read32(core, CSR(STREAM)), STREAM, WORDS_LOG2);
  const uint32_t room = words ? (uint32_t)1 << words : 0;
  return image->stream_a_words <= room && image->stream_b_words <= room &&
         FIELD(config, CONFIG, SLOTS) == image->slots &&
         FIELD(config, CONFIG, FMA_PIPES) == image->fma_pipes &&
         image->bundles <= (uint32_t)1 << FIELD(config, CONFIG, PROGRAM_LOG2) &&
         image->data_words <= (uint32_t)1 << FIELD(config, CONFIG, DATA_LOG2);
}

/* Words of a pipe's stream, page by page. */
static void load_stream(const asip *core, uint32_t first_page, const uint32_t *words,
                        uint32_t count) {
  const uint32_t page_words = sizeof(((asip_t *)0)->streams) / sizeof(uint32_t);
  uint32_t i;
  for (i = 0; i < count; i++) {
    if (i % page_words == 0) write32(core, CSR(STREAM), first_page + i / page_words);
    write32(core, ASIP_WORD(streams) + i % page_words, words[i]);
  }
}

asip_result asip_load(asip *core, const asip_image *image) {
  const uint32_t *word = image->program;
  uint32_t i, lane;

  if (asip_check_id(core) != ASIP_OK) return ASIP_NO_CORE;
  if (!fits(core, image)) return ASIP_WRONG_CORE;
  if (FIELD(read32(core, CSR(STATUS)), STATUS, BUSY)) return ASIP_BUSY;

  asip_clear(core);
  for (i = 0; i < image->bundles; i++) {
    for (lane = 0; lane < image->lanes; lane++) {
      write32(core, ASIP_WORD(program) + 4 * i + lane, *word++);
    }
  }
  for (i = 0; i < image->constant_count; i++) {
    write32(core, ASIP_WORD(constants) + image->constants[i].address, image->constants[i].word);
  }
  for (i = 0; i < image->data_words; i++) write32(core, ASIP_WORD(data) + i, image->data[i]);
  load_stream(core, 0, image->stream_a, image->stream_a_words);
  load_stream(core, ASIP_STREAM_B_PAGE, image->stream_b, image->stream_b_words);
  for (i = 0; i < image->output_count; i++) write32(core, ASIP_WORD(safe) + i, image->safe[i]);
  write32(core, CSR(ENTRY), image->entry);
  write32(core, CSR(WATCHDOG), image->watchdog);
  write32(core, CSR(OUTPUT_MASK), image->output_mask);
  core->image = image;
  asip_preset_states(core);
  return ASIP_OK;
}

void asip_preset_states(const asip *core) {
  uint32_t i;
  for (i = 0; i < core->image->state_count; i++) {
    asip_preset_state(core, i, core->image->states[i].word);
  }
}

void asip_preset_state(const asip *core, unsigned state, uint32_t word) {
  write32(core, ASIP_WORD(registers) + core->image->states[state].address, word);
}

void asip_preset_data(const asip *core, uint32_t address, const uint32_t *words, uint32_t count) {
  uint32_t i;
  for (i = 0; i < count; i++) write32(core, ASIP_WORD(data) + address + i, words[i]);
}

void asip_set_inputs(const asip *core, const uint32_t *words) {
  uint32_t i;
  for (i = 0; i < core->image->input_count; i++) {
    write32(core, ASIP_WORD(constants) + core->image->inputs[i], words[i]);
  }
}

void asip_start(const asip *core) { write32(core, CSR(CONTROL), MASK(CONTROL, START)); }

asip_result asip_wait(const asip *core, uint32_t polls) {
  while (polls-- > 0) {
    const uint32_t status = read32(core, CSR(STATUS));
    if (status & MASK(STATUS, BUSY)) continue;
    if (status & MASK(STATUS, FAULT)) return ASIP_FAULTED;
    return status & MASK(STATUS, DONE) ? ASIP_OK : ASIP_NOT_STARTED;
  }
  return ASIP_TIMEOUT;
}

void asip_read_outputs(const asip *core, uint32_t *words) {
  uint32_t i;
  for (i = 0; i < core->image->output_count; i++) words[i] = read32(core, ASIP_WORD(outputs) + i);
}

asip_result asip_tick(const asip *core, const uint32_t *inputs, uint32_t *outputs, uint32_t polls) {
  asip_result result;
  asip_set_inputs(core, inputs);
  asip_start(core);
  result = asip_wait(core, polls);
  if (result == ASIP_OK || result == ASIP_FAULTED) asip_read_outputs(core, outputs);
  return result;
}

asip_result asip_checked_tick(const asip *core, const uint32_t *inputs, uint32_t *outputs,
                              uint32_t polls) {
  asip_result result;
  asip_set_inputs(core, inputs);
  asip_start(core);
  result = asip_wait(core, polls);
  if (result == ASIP_NOT_STARTED) result = asip_wait(core, polls); /* a bit of STATUS on its way */
  if (result == ASIP_OK || result == ASIP_FAULTED) asip_read_outputs(core, outputs);
  if (result != ASIP_OK || !FIELD(read32(core, CSR(STATUS)), STATUS, FAULT)) return result;
  asip_read_outputs(core, outputs);
  return ASIP_FAULTED;
}

static int has_record(const asip *core, unsigned output) {
  return output < ASIP_RECORDS && FIELD(read32(core, CSR(CONFIG)), CONFIG, PLAUSIBLE);
}

asip_result asip_set_plausible(const asip *core, unsigned output, float least, float most,
                               float slew) {
  if (!has_record(core, output)) return ASIP_NO_RECORD;
  if (!(least <= most) || !(slew >= 0)) return ASIP_BAD_RECORD; /* NaN compares false */
  write32(core, ASIP_WORD(plausible_least) + output, asip_word(least));
  write32(core, ASIP_WORD(plausible_most) + output, asip_word(most));
  write32(core, ASIP_WORD(plausible_slew) + output, asip_word(slew));
  write32(core, ASIP_WORD(plausible_on) + output, ASIP__PLAUSIBLE_ON__ENTRY__JUDGED_bm);
  return ASIP_OK;
}

asip_result asip_end_plausible(const asip *core, unsigned output) {
  if (!has_record(core, output)) return ASIP_NO_RECORD;
  write32(core, ASIP_WORD(plausible_on) + output, 0);
  return ASIP_OK;
}

void asip_select(const asip *core, const asip_function *function) {
  write32(core, CSR(ENTRY), function->entry);
  write32(core, CSR(WATCHDOG), function->watchdog);
  write32(core, CSR(OUTPUT_MASK), function->output_mask);
}

asip_result asip_function_tick(const asip *core, const asip_function *function,
                               const uint32_t *inputs, uint32_t *outputs, uint32_t polls) {
  const uint16_t *places = core->image->inputs + function->first_input;
  asip_result result;
  uint32_t i;

  asip_select(core, function);
  for (i = 0; i < function->input_count; i++) {
    write32(core, ASIP_WORD(constants) + places[i], inputs[i]);
  }
  asip_start(core);
  result = asip_wait(core, polls);
  if (result == ASIP_OK || result == ASIP_FAULTED) {
    for (i = 0; i < function->output_count; i++) {
      outputs[i] = read32(core, ASIP_WORD(outputs) + function->first_output + i);
    }
  }
  return result;
}

void asip_preset_function(const asip *core, const asip_function *function) {
  uint32_t i;
  for (i = 0; i < function->state_count; i++) {
    const unsigned state = function->first_state + i;
    asip_preset_state(core, state, core->image->states[state].word);
  }
}

uint32_t asip_read_export(const asip *core, unsigned number) {
  return read32(core, ASIP_WORD(registers) + core->image->exports[number]);
}

void asip_clear(const asip *core) { write32(core, CSR(CONTROL), MASK(CONTROL, CLEAR)); }

void asip_enable_interrupts(const asip *core, int done, int fault) {
  write32(core, CSR(IRQ_ENABLE),
          (done ? MASK(IRQ_ENABLE, DONE) : 0u) | (fault ? MASK(IRQ_ENABLE, FAULT) : 0u));
}

asip_state asip_status(const asip *core) {
  const uint32_t status = read32(core, CSR(STATUS));
  asip_state state;
  state.busy = (int)FIELD(status, STATUS, BUSY);
  state.done = (int)FIELD(status, STATUS, DONE);
  state.faulted = (int)FIELD(status, STATUS, FAULT);
  state.repaired = (int)FIELD(status, STATUS, REPAIRED);
  state.cause = (asip_fault)FIELD(status, STATUS, CAUSE);
  state.flags = (uint8_t)FIELD(status, STATUS, FLAGS);
  state.cycles = read32(core, CSR(CYCLES));
  state.info = read32(core, CSR(FAULT_INFO));
  return state;
}

const char *asip_fault_text(asip_fault cause) {
  switch (cause) {
#define CASE(name, code, text) \
  case ASIP_FAULT_##name:      \
    return text;
    ASIP_FAULTS(CASE)
#undef CASE
    default:
      return "unknown fault";
  }
}

const char *asip_result_text(asip_result result) {
  switch (result) {
    case ASIP_OK:
      return "ok";
    case ASIP_NO_CORE:
      return "no ASIP at this address";
    case ASIP_WRONG_CORE:
      return "image does not fit this core";
    case ASIP_BUSY:
      return "a run is going on";
    case ASIP_FAULTED:
      return "stopped by a fault";
    case ASIP_NOT_STARTED:
      return "no run was started";
    case ASIP_TIMEOUT:
      return "run did not end in time";
    case ASIP_NO_RECORD:
      return "no plausibility record of this output";
    case ASIP_BAD_RECORD:
      return "bounds of a plausibility record that are none";
  }
  return "unknown result";
}

uint32_t asip_word(float value) {
  uint32_t word;
  memcpy(&word, &value, sizeof word);
  return word;
}

float asip_float(uint32_t word) {
  float value;
  memcpy(&value, &word, sizeof value);
  return value;
}
