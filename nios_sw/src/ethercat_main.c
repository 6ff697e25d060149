/* SPDX-License-Identifier: Apache-2.0 */
/* The device on the bus on a Nios II system: states, mailbox and drives of nios_sw/ethercat that use the slave
 * controller. A control tick (the timer of the machine, each CYCLE_100NS) has the words of ethercat_tick.h.
 *
 * The control pass is an interrupt, so that no work for the mailbox delays it. The machine's tick requests none:
 * the core's timer does, when the next tick is due, and once more each LATE cycles until it has come. */
#include "ethercat/al.h"
#include "ethercat/application.h"
#include "ethercat/esc_nios.h"
#include "ethercat/held.h"
#include "ethercat/ethercat_tick.h"
#include "io.h"

#define PERIOD (CYCLE_100NS * CLOCK_MHZ / 10u)
#define WORDS 60u /* clocks in which a machine writes and reads the words of a tick */
#define MEASURED 16u /* ticks of a measurement */
#define WRONG 3u     /* measurements in a row after which the period is wrong */
#define LATE 256u /* about three times what an interrupt without a tick costs */

static struct feedback feedback;
static struct command command;

/* What changes seldom is divided among the axes when it does. */
static void take_switches(const volatile struct ethercat_input *in) {
  static uint32_t before;
  uint32_t digital = in->digital_inputs, ages;
  if (digital == before) return;
  before = digital;
  feedback.digital_inputs = (uint8_t)digital;
  ages = in->edge_ages;
  feedback.edge_age[0] = (uint16_t)ages;
  feedback.edge_age[1] = (uint16_t)(ages >> 16);
  for (int n = 0; n < AXES; ++n) feedback.axis[n].switches = digital >> (TICK_SWITCHES + 3 * n) & 7u;
}

static void take_index(const volatile struct ethercat_input *in) {
  static uint32_t before;
  uint32_t counts = in->index_counts;
  if (counts == before) return;
  before = counts;
  for (int n = 0; n < AXES; ++n) {
    feedback.axis[n].index_count = counts >> 6 * n & 63u;
    feedback.axis[n].index_position = in->index_position[n];
  }
}

static void take(const volatile struct ethercat_input *in) {
  HELD(in);
  for (int n = 0; n < AXES; ++n) {
    uint32_t torque_fault = (uint32_t)in->torque_fault[n];
    feedback.axis[n].position = in->position[n];
    feedback.axis[n].torque = (int16_t)torque_fault;
    feedback.axis[n].fault = (uint16_t)(torque_fault >> 16);
    feedback.pose[n] = in->pose[n];
  }
  take_switches(in);
  take_index(in);
}

static void give(volatile struct ethercat_output *out) {
  HELD(out);
  for (int n = 0; n < AXES; ++n) {
    const struct axis_command axis = command.axis[n]; /* all loads, then all stores: none waits for a load */
    uint32_t flags = (axis.power ? TICK_POWER : 0u) | (axis.torque_only ? TICK_TORQUE_ONLY : 0u);
    out->position[n] = axis.position;
    out->fraction[n] = axis.fraction;
    out->velocity[n] = axis.velocity;
    out->acceleration[n] = axis.acceleration;
    out->torque_flags[n] = (uint16_t)axis.torque | flags;
  }
  out->digital_outputs = command.digital_outputs;
  out->setting_number = command.setting_number;
  out->setting_place = (uint32_t)command.setting_index << 8 | command.setting_subindex;
  out->setting_value = command.setting_value;
}

/* The next interrupt. */
static void wake_in(uint32_t cycles) {
  io_write(REG_TIMER_PERIOD, cycles); /* counts from here */
  io_write(REG_TIMER_STATUS, 0);
}

/* The period is a parameter of the hardware too: with another one, speeds and times would be wrong. The first
 * MEASURED passes do not count: they are late. */
static void check_period(void) {
  static uint32_t passes, first_tick, first_clock, wrong;
  static bool known;
  uint32_t tick, clock, period;
  if (known || ++passes % MEASURED) return;
  tick = io_read(REG_TICK_COUNT);
  clock = io_read(REG_CYCLE) - io_read(REG_TICK_CYCLES);
  if (passes > MEASURED) {
    period = (clock - first_clock) / (tick - first_tick);
    known = period >= PERIOD - PERIOD / 256u && period <= PERIOD + PERIOD / 256u;
    if (!known && ++wrong == WRONG) {
      known = true;
      console_text("The control ticks do not come each ");
      console_decimal(PERIOD);
      console_text(" clocks, the cycle of this program: set Period of ethercat_nios, or build with -DCYCLE_100NS\n");
      al_halt(AL_WRONG_PERIOD);
    }
  }
  first_tick = tick;
  first_clock = clock;
}

static void pass(void) {
  static bool started;
  volatile struct ethercat_output *out = (volatile struct ethercat_output *)OUTPUT_BASE;
  if (!(io_read(REG_TICK_STATUS) & TICK_STATUS_PENDING)) {
    wake_in(LATE);
    return;
  }
  take((const volatile struct ethercat_input *)INPUT_BASE);
  application_cycle(&feedback, &command);
  give(out);
  io_write(REG_TICK_DONE, 0);
  objects.pass_cycles = io_read(REG_TICK_CYCLES);
  /* The first one waited for the start of the program. */
  if (started && objects.pass_cycles > objects.pass_longest) objects.pass_longest = objects.pass_cycles;
  if (started && objects.pass_cycles > PERIOD - WORDS && objects.output_sync.exceeded < 0xFFFFu) ++objects.output_sync.exceeded;
  started = true;
  check_period();
  objects.output_sync.copy = objects.input_sync.copy = objects.pass_longest * (1000u / CLOCK_MHZ);
  wake_in(objects.pass_cycles + LATE < PERIOD ? PERIOD - objects.pass_cycles : LATE);
}

int main(void) {
  application_start();
  esc_load_image();
  timer_start(LATE, pass);
  for (;;) application_background();
}
