// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated pulse generator: long runs at a given rate, with the clocks of the pulses.
#include <cstdint>

#include "Vpulse_generator.h"
#include "bench.h"

namespace {

struct Pulses : Bench<Pulses, Vpulse_generator> {
  Pulses() {
    top->clear_i = 0;
    top->rate_i = 0;
    reset(2);
  }
};

}  // namespace

extern "C" {

void* pulses_new() { return new Pulses; }
void pulses_delete(void* handle) { delete static_cast<Pulses*>(handle); }

void pulses_clear(void* handle) {
  Pulses* p = static_cast<Pulses*>(handle);
  p->top->clear_i = 1;
  p->clock();
  p->top->clear_i = 0;
}

// Runs `clocks` at `rate` and returns the pulses seen; the numbers (from 1) of the clocks after which the
// first n of them are high go to `at`.

uint64_t pulses_run(void* handle, uint32_t rate, uint64_t clocks, uint64_t* at, uint64_t n) {
  Pulses* p = static_cast<Pulses*>(handle);
  p->top->rate_i = rate;
  uint64_t count = 0;
  for (uint64_t i = 1; i <= clocks; ++i) {
    p->clock();
    if (p->top->pulse_o) {
      if (count < n) at[count] = i;
      ++count;
    }
  }
  return count;
}

uint32_t pulses_count(void* handle) { return static_cast<Pulses*>(handle)->top->count_o; }

}  // extern "C"
