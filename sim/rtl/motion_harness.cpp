// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated motion front-end: bus accesses, time, and the edges of the drive lines,
// called from Python (motion_rtl.py).
#include <cstdint>

#include "Vmotion_front_end.h"
#include "bench.h"

namespace {

constexpr uint64_t kBusTimeout = 100;

struct Edge {
  uint64_t clock;      // in which the lines have their new level
  uint32_t step;       // all step lines
  uint32_t direction;  // all direction lines
};

struct Motion : Bench<Motion, Vmotion_front_end> {
  uint32_t step = 0, direction = 0;
  std::vector<Edge> edges;

  uint64_t started = 0;  // clock after the reset

  Motion() {
    top->read_i = top->write_i = 0;
    reset(4, 0);
    started = clocks;
  }

  uint64_t now() const { return clocks - started; }

  void edge() {
    rise();
    if (top->step_o != step || top->direction_o != direction) {
      step = top->step_o;
      direction = top->direction_o;
      edges.push_back({now(), step, direction});
    }
  }
};

}  // namespace

extern "C" {

void* motion_new() { return new Motion; }
void motion_delete(void* handle) { delete static_cast<Motion*>(handle); }

void motion_write(void* handle, uint32_t address, uint32_t data) {
  static_cast<Motion*>(handle)->access(address, &data, true, kBusTimeout);
}

// Returns 0 if the bus never answers.
int motion_read(void* handle, uint32_t address, uint32_t* data) {
  return static_cast<Motion*>(handle)->access(address, data, false, kBusTimeout);
}

// Lets time pass, until irq_o is high where requested; returns the clocks that passed.
uint64_t motion_clock(void* handle, uint64_t clocks, int until_irq) {
  Motion* m = static_cast<Motion*>(handle);
  for (uint64_t i = 0; i < clocks; ++i) {
    if (until_irq && m->top->irq_o) return i;
    m->clock();
  }
  return clocks;
}

uint64_t motion_now(void* handle) { return static_cast<Motion*>(handle)->now(); }

uint64_t motion_edges(void* handle, uint64_t* clock, uint32_t* step, uint32_t* direction, uint64_t n) {
  Motion* m = static_cast<Motion*>(handle);
  for (uint64_t i = 0; i < n && i < m->edges.size(); ++i) {
    clock[i] = m->edges[i].clock;
    step[i] = m->edges[i].step;
    direction[i] = m->edges[i].direction;
  }
  return m->edges.size();
}

void motion_forget_edges(void* handle) { static_cast<Motion*>(handle)->edges.clear(); }

}  // extern "C"
