// SPDX-License-Identifier: Apache-2.0
// C interface of a DualBench that is called System: bus accesses and whole periods, called from Python
// (dual_rtl.py). One call does all of one or many periods.
#pragma once
#include "dual_bench.h"

extern "C" {

void* dual_new() { return new System; }
void dual_free(void* handle) { delete static_cast<System*>(handle); }

int dual_write(void* handle, uint32_t address, uint32_t data) {
  return static_cast<System*>(handle)->access_in_turn(address, &data, true);
}

int dual_read(void* handle, uint32_t address, uint32_t* data) {
  return static_cast<System*>(handle)->access_in_turn(address, data, false);
}

// Lets the host write as soon as the bus allows, while time passes in other calls.
void dual_queue(void* handle, const Write* writes, uint64_t n) {
  auto& queue = static_cast<System*>(handle)->queue;
  queue.insert(queue.end(), writes, writes + n);
}

uint64_t dual_queued(void* handle) { return static_cast<System*>(handle)->queue.size(); }

void dual_clock(void* handle, uint64_t clocks) {
  for (uint64_t i = 0; i < clocks; ++i) static_cast<System*>(handle)->clock();
}

uint64_t dual_clocks(void* handle) { return static_cast<System*>(handle)->clocks; }

// Bit 0: irq_o, bit 1: stop_o.
int dual_lines(void* handle) {
  auto* top = static_cast<System*>(handle)->top.get();
  return top->irq_o | top->stop_o << 1;
}

// Runs whole periods; returns how many, fewer if the system hangs.
uint64_t dual_run(void* handle, Period* periods, uint64_t n) {
  for (uint64_t i = 0; i < n; ++i)
    if (!static_cast<System*>(handle)->period(&periods[i])) return i;
  return n;
}

}  // extern "C"
