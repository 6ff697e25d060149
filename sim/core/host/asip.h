/* SPDX-License-Identifier: Apache-2.0 */
/* Driver of the ASIP in plain C99: no operating system, no heap, no state of its own.
 * Bus traffic goes through an asip_bus, word addresses of docs/regmap.md. Not reentrant per core.
 * Inputs, outputs, states are raw 32-bit words: binary32 (asip_word, asip_float) or int32.
 * The core holds accesses to its memories while a program runs: such a call can take that long. */
#ifndef ASIP_H
#define ASIP_H

#include <stddef.h>
#include <stdint.h>

#include "gen/asip_faults.h"
#include "gen/asip_regs.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Word address of a register or block, such as csr.STATUS or constants. */
#define ASIP_WORD(member) ((uint32_t)(offsetof(asip_t, member) / sizeof(uint32_t)))

/* First page of the stream of pipe B (register STREAM). */
#define ASIP_STREAM_B_PAGE ((uint32_t)32)

/* Outputs that have a plausibility record. */
#define ASIP_RECORDS ((uint32_t)(sizeof(asip__plausible_on_t) / sizeof(uint32_t)))

/* How the host reaches the core: single 32-bit accesses by word address. */
typedef struct {
  uint32_t (*read32)(void *context, uint32_t address);
  void (*write32)(void *context, uint32_t address, uint32_t data);
  void *context;
} asip_bus;

/* Word and where it goes: index in bank K, or offset in block `registers`. */
typedef struct {
  uint16_t address;
  uint32_t word;
} asip_word_at;

/* Program image as `asip-as --format c` writes it. Absent tables are null, their length 0. */
typedef struct {
  const char *title;
  uint8_t slots, fma_pipes; /* configuration it is for */
  uint8_t lanes;            /* 32-bit words per bundle */
  uint16_t entry;
  uint32_t watchdog, output_mask;
  uint16_t bundles;
  const uint32_t *program; /* lane 0 of bundle 0 first */
  uint16_t program_words;
  const asip_word_at *constants;
  uint16_t constant_count;
  const uint32_t *data;
  uint16_t data_words;
  const uint32_t *safe; /* safe value per output */
  uint16_t output_count;
  const asip_word_at *states; /* initial values */
  uint16_t state_count;
  const uint16_t *inputs; /* index in bank K per input */
  uint16_t input_count;
  const uint16_t *exports; /* offset in block `registers` per export */
  uint16_t export_count;
  const uint32_t *stream_a; /* constant memory of each multiply-add pipe, from its word 0 */
  uint16_t stream_a_words;
  const uint32_t *stream_b;
  uint16_t stream_b_words;
} asip_image;

/* One of several functions of an image: its entry, and where its words are in the image's tables. */
typedef struct {
  const char *name;
  uint16_t entry;
  uint32_t watchdog, output_mask;
  uint16_t first_input, input_count;
  uint16_t first_output, output_count;
  uint16_t first_state, state_count;
} asip_function;

/* A core and the image loaded into it. */
typedef struct {
  asip_bus bus;
  const asip_image *image;
} asip;

typedef enum {
  ASIP_OK = 0,
  ASIP_NO_CORE,     /* ID is not the ASIP's */
  ASIP_WRONG_CORE,  /* image for another configuration, or larger than the core's memories */
  ASIP_BUSY,        /* a run is going on */
  ASIP_FAULTED,     /* a fault is latched, asip_clear ends it; outputs are the safe values */
  ASIP_NOT_STARTED, /* neither busy nor done */
  ASIP_TIMEOUT,     /* still busy after the polls allowed */
  ASIP_NO_RECORD,   /* the core has no plausibility record, or none of this output */
  ASIP_BAD_RECORD   /* a bound is NaN, least above most, or slew below 0 */
} asip_result;

#define ASIP_FAULT_CODE(name, code, text) ASIP_FAULT_##name = (code),
typedef enum { ASIP_FAULTS(ASIP_FAULT_CODE) } asip_fault;
#undef ASIP_FAULT_CODE

/* State of the core, decoded from STATUS, CYCLES, FAULT_INFO. */
typedef struct {
  int busy, done, faulted;
  int repaired; /* a core with redundancy: the last tick took a third run */
  asip_fault cause;
  uint8_t flags;   /* IEEE 754 exceptions of the run: NV DZ OF UF NX, bit 4..0 */
  uint32_t cycles; /* of the current or last run */
  uint32_t info;   /* FAULT_INFO: bundle address or output index, see docs/regmap.md */
} asip_state;

/* Bus of a core that is mapped into memory; `base` is the address of its first word. */
asip_bus asip_memory_bus(volatile uint32_t *base);

/* ASIP_OK or ASIP_NO_CORE. */
asip_result asip_check_id(const asip *core);

/* Clear a fault, write program, constants, data, safe values, run parameters, initial states.
 * The image stays in use: it must live as long as the core runs it.
 * ASIP_OK, ASIP_NO_CORE, ASIP_WRONG_CORE, ASIP_BUSY; nothing is written unless ASIP_OK. */
asip_result asip_load(asip *core, const asip_image *image);

/* Write the initial value of every state, as asip_load does: a run that ended in a fault may have
 * left anything in them. */
void asip_preset_states(const asip *core);

/* Write one state register by its number in the image, for instance the first encoder counts. */
void asip_preset_state(const asip *core, unsigned state, uint32_t word);

/* Write words of data memory from an address on, for instance a plan to begin with. */
void asip_preset_data(const asip *core, uint32_t address, const uint32_t *words, uint32_t count);

/* Write all inputs in the order of the program. */
void asip_set_inputs(const asip *core, const uint32_t *words);

/* Start a run. A core that is busy or faulted ignores it. */
void asip_start(const asip *core);

/* Read STATUS until the run has ended, at most `polls` times.
 * ASIP_OK, ASIP_FAULTED, ASIP_NOT_STARTED, ASIP_TIMEOUT. */
asip_result asip_wait(const asip *core, uint32_t polls);

/* Read all outputs, image->output_count words: those of the last run; safe values if that ended in
 * a fault, and before the first. */
void asip_read_outputs(const asip *core, uint32_t *words);

/* One tick: write all inputs, start, wait at most `polls` reads of STATUS, read all outputs.
 * Results of asip_wait. After ASIP_FAULTED the outputs are the safe values, asip_status has the
 * cause, and asip_clear with asip_preset_states goes on. After the others they are not read. */
asip_result asip_tick(const asip *core, const uint32_t *inputs, uint32_t *outputs, uint32_t polls);

/* asip_tick of a core with redundancy (CONFIG.resilience): STATUS is read again after the outputs,
 * because a bit that flips in a stored output is found when it is read, and where it reports no run,
 * because a bit of it may have flipped on its way. After ASIP_FAULTED the
 * outputs are the safe values; load the image again if the cause is MEMORY, CONTROL or DISAGREE. */
asip_result asip_checked_tick(const asip *core, const uint32_t *inputs, uint32_t *outputs,
                              uint32_t polls);

/* Plausibility record of an output, 0 to ASIP_RECORDS - 1, in a core that has one
 * (CONFIG.plausible): from the next run on a word below `least`, above `most`, or further than
 * `slew` from the last one committed ends the run with the fault IMPLAUSIBLE, and outputs are the
 * safe values. Infinities limit nothing. Waits while a run goes on; holds until the core is reset,
 * asip_load leaves it. Bounds of one output change together if no run starts meanwhile.
 * ASIP_OK, ASIP_NO_RECORD, ASIP_BAD_RECORD; nothing is written unless ASIP_OK. */
asip_result asip_set_plausible(const asip *core, unsigned output, float least, float most,
                               float slew);

/* The output is not checked from the next run on. ASIP_OK or ASIP_NO_RECORD. */
asip_result asip_end_plausible(const asip *core, unsigned output);

/* The next runs are of this function of the image: three writes. asip_load selects the first. */
void asip_select(const asip *core, const asip_function *function);

/* One tick of a function: select it, write its inputs, start, wait, read its outputs, the words of
 * which are valid until another function runs. Results of asip_tick. */
asip_result asip_function_tick(const asip *core, const asip_function *function,
                               const uint32_t *inputs, uint32_t *outputs, uint32_t polls);

/* Write the initial values of a function's states, as after a fault of it. */
void asip_preset_function(const asip *core, const asip_function *function);

/* Read one exported register by its number in the image, after a run. */
uint32_t asip_read_export(const asip *core, unsigned number);

/* End done and fault, and with them the interrupt. Ignored while busy. */
void asip_clear(const asip *core);

/* Interrupt at the end of a run and at a fault. */
void asip_enable_interrupts(const asip *core, int done, int fault);

asip_state asip_status(const asip *core);
const char *asip_fault_text(asip_fault cause);
const char *asip_result_text(asip_result result);

/* Bits of a binary32 and back. */
uint32_t asip_word(float value);
float asip_float(uint32_t word);

#ifdef __cplusplus
}
#endif

#endif
