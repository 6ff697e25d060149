// SPDX-License-Identifier: Apache-2.0
// A Verilated system with two processors in it: bus accesses, a host's queue of writes, whole periods.
// A harness derives `struct X : DualBench<X, Vtop>`, may replace edge() and measure(), and names itself System
// before it includes dual_api.h.
#pragma once
#include <cstdint>
#include <deque>

#include "bench.h"

constexpr uint64_t kTimeout = 1000000;  // clocks; above every run and period
constexpr uint32_t kMeasured = 5, kCommands = 5, kWords = 15;

struct Period {
  uint32_t measured[kMeasured];  // in
  uint32_t commands[kCommands];  // out, at the end of the period's work
  uint32_t words[kWords];        // last set-point on its way into the buffer
  uint32_t stored;               // words of it in this period
  uint32_t updates;              // command updates in this period
  uint32_t command_clock;        // clocks from the period's start to the last update
  uint32_t set_point_clock;      // clocks from the period's start to the last word of the set-point
  uint32_t cycles[2];            // of the runs of the trajectory and the tracking core that ended
  uint32_t torn;                 // clocks in which commands changed without an update the clock before
  uint32_t used;                 // clocks from the period's start to the end of its work
  uint32_t late;                 // 1: the next period began before
};

struct Write {
  uint32_t address, data;
};

template <typename Self, typename Model>
struct DualBench : Bench<Self, Model> {
  using Base = Bench<Self, Model>;
  using Base::clocks;
  using Base::top;

  uint32_t words[kWords] = {};
  uint32_t stored = 0, updates = 0, torn = 0, cycles[2] = {}, command[kCommands] = {};
  bool update = false;  // in the clock before
  uint64_t updated = 0, last_stored = 0;
  std::deque<Write> queue;  // the host's writes, done while time passes

  void begin() {
    top->read_i = top->write_i = 0;
    top->address_i = 0;
    top->writedata_i = 0;
    Base::reset();
  }

  // Of the measured words of a period, before its first clock, after it and at the end of its work.
  void measure(Period*, bool) {}

  void settle() {
    if (!queue.empty()) {
      top->address_i = queue.front().address;
      top->writedata_i = queue.front().data;
      top->write_i = 1;
    }
    Base::settle();
  }

  void edge() {
    const bool written = !queue.empty() && !top->waitrequest_o;
    if (top->trace_store_o) {
      if (top->trace_index_o < kWords) words[top->trace_index_o] = top->trace_data_o;
      ++stored;
      last_stored = clocks;
    }
    for (uint32_t i = 0; i < kCommands; ++i) {
      torn += top->command_o[i] != command[i] && !update;
      command[i] = top->command_o[i];
    }
    update = top->command_valid_o;
    if (update) {
      ++updates;
      updated = clocks;
    }
    for (uint32_t n = 0; n < 2; ++n)
      if (top->trace_cycles_o >> n & 1) cycles[n] = top->trace_data_o;
    Base::rise();
    if (written) {
      queue.pop_front();
      top->write_i = 0;
    }
  }

  // One bus access after all that wait; false if it is not answered.
  bool access_in_turn(uint32_t address, uint32_t* data, bool is_write) {
    for (uint64_t n = 0; !queue.empty(); ++n) {
      if (n > kTimeout) return false;
      Base::clock();
    }
    return Base::access(address, data, is_write);
  }

  // One period: from its first clock to the end of its work, or to the first clock of the next one.
  bool period(Period* p) {
    uint64_t n = 0;
    for (settle(); !top->period_o; settle()) {
      self().edge();
      if (++n > kTimeout) return false;
    }
    self().measure(p, true);
    settle();
    const uint64_t begin = clocks;
    stored = updates = torn = cycles[0] = cycles[1] = 0;
    for (n = 0;;) {
      self().edge();
      if (n == 0) self().measure(p, false);
      settle();
      p->late = top->period_o;
      if (top->finished_o || top->period_o) break;
      if (++n > kTimeout) return false;
    }
    self().measure(p, true);
    p->used = clocks - begin;
    p->stored = stored;
    p->updates = updates;
    p->command_clock = updates ? updated - begin : 0;
    p->torn = torn;
    p->set_point_clock = stored ? last_stored - begin : 0;
    for (uint32_t i = 0; i < 2; ++i) p->cycles[i] = cycles[i];
    for (uint32_t i = 0; i < kCommands; ++i) p->commands[i] = top->command_o[i];
    for (uint32_t i = 0; i < kWords; ++i) p->words[i] = words[i];
    return true;
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};
