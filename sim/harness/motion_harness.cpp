// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated motion front-end: bus accesses, time, and the edges of the drive lines,
// called from Python (motion_rtl.py).
#include <cstdint>
#include <memory>
#include <vector>

#include "Vmotion_front_end.h"
#include "verilated.h"

namespace {

constexpr uint64_t kBusTimeout = 100;

struct Edge {
  uint64_t clock;      // in which the lines have their new level
  uint32_t step;       // all step lines
  uint32_t direction;  // all direction lines
};

struct Motion {
  VerilatedContext context;
  std::unique_ptr<Vmotion_front_end> top;
  uint64_t clocks = 0;
  uint32_t step = 0, direction = 0;
  std::vector<Edge> edges;

  Motion() : top(new Vmotion_front_end(&context)) {
    top->read_i = top->write_i = 0;
    top->rst_ni = 0;
    for (int i = 0; i < 4; ++i) clock();
    top->rst_ni = 1;
    clocks = 0;
  }

  void clock() {
    top->clk_i = 0;
    top->eval();
    top->clk_i = 1;
    top->eval();
    ++clocks;
    if (top->step_o != step || top->direction_o != direction) {
      step = top->step_o;
      direction = top->direction_o;
      edges.push_back({clocks, step, direction});
    }
  }
};

}  // namespace

extern "C" {

void* motion_new() { return new Motion; }
void motion_delete(void* handle) { delete static_cast<Motion*>(handle); }

void motion_write(void* handle, uint32_t address, uint32_t data) {
  Motion* m = static_cast<Motion*>(handle);
  m->top->address_i = address;
  m->top->writedata_i = data;
  m->top->write_i = 1;
  m->clock();
  m->top->write_i = 0;
}

// Returns 0 if the bus never answers.
int motion_read(void* handle, uint32_t address, uint32_t* data) {
  Motion* m = static_cast<Motion*>(handle);
  m->top->address_i = address;
  m->top->read_i = 1;
  for (uint64_t i = 0; i < kBusTimeout; ++i) {
    m->top->clk_i = 0;
    m->top->eval();
    const bool answered = !m->top->waitrequest_o;
    *data = m->top->readdata_o;
    m->clock();
    if (answered) {
      m->top->read_i = 0;
      return 1;
    }
  }
  return 0;
}

// Lets time pass, until irq_o is high where asked for; returns the clocks that passed.
uint64_t motion_clock(void* handle, uint64_t clocks, int until_irq) {
  Motion* m = static_cast<Motion*>(handle);
  for (uint64_t i = 0; i < clocks; ++i) {
    if (until_irq && m->top->irq_o) return i;
    m->clock();
  }
  return clocks;
}

uint64_t motion_now(void* handle) { return static_cast<Motion*>(handle)->clocks; }

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
