// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated two-processor system: bus accesses and whole periods, called from Python
// (dual_rtl.py). One call does all of one or many periods.
#include <cstdint>
#include <deque>

#include "Vdual_asip.h"
#include "bench.h"

namespace {

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

struct Dual : Bench<Dual, Vdual_asip> {
  uint32_t words[kWords] = {};
  uint32_t stored = 0, updates = 0, torn = 0, cycles[2] = {}, command[kCommands] = {};
  bool update = false;  // in the clock before
  uint64_t updated = 0, last_stored = 0;
  std::deque<Write> queue;  // the host's writes, done while time passes

  Dual() {
    top->read_i = top->write_i = 0;
    top->address_i = 0;
    top->writedata_i = 0;
    for (uint32_t i = 0; i < kMeasured; ++i) top->measured_i[i] = 0;
    reset();
  }

  void settle() {
    if (!queue.empty()) {
      top->address_i = queue.front().address;
      top->writedata_i = queue.front().data;
      top->write_i = 1;
    }
    Bench::settle();
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
    rise();
    if (written) {
      queue.pop_front();
      top->write_i = 0;
    }
  }

  // One bus access behind all that wait; false if it is not answered.
  bool access_in_turn(uint32_t address, uint32_t* data, bool is_write) {
    for (uint64_t n = 0; !queue.empty(); ++n) {
      if (n > kTimeout) return false;
      clock();
    }
    return access(address, data, is_write);
  }

  // One period: from its first clock to the end of its work, or to the first clock of the next one. While
  // the work is under way, the lines hold the complements of the measured words, but for the first clock.
  bool period(Period* p) {
    uint64_t n = 0;
    for (settle(); !top->period_o; settle()) {
      edge();
      if (++n > kTimeout) return false;
    }
    for (uint32_t i = 0; i < kMeasured; ++i) top->measured_i[i] = p->measured[i];
    settle();
    const uint64_t begin = clocks;
    stored = updates = torn = cycles[0] = cycles[1] = 0;
    for (n = 0;;) {
      edge();
      if (n == 0)
        for (uint32_t i = 0; i < kMeasured; ++i) top->measured_i[i] = ~p->measured[i];
      settle();
      p->late = top->period_o;
      if (top->finished_o || top->period_o) break;
      if (++n > kTimeout) return false;
    }
    for (uint32_t i = 0; i < kMeasured; ++i) top->measured_i[i] = p->measured[i];
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
};

}  // namespace

extern "C" {

void* dual_new() { return new Dual; }
void dual_free(void* handle) { delete static_cast<Dual*>(handle); }

int dual_write(void* handle, uint32_t address, uint32_t data) {
  return static_cast<Dual*>(handle)->access_in_turn(address, &data, true);
}

int dual_read(void* handle, uint32_t address, uint32_t* data) {
  return static_cast<Dual*>(handle)->access_in_turn(address, data, false);
}

// Lets the host write as soon as the bus allows, while time passes in other calls.
void dual_queue(void* handle, const Write* writes, uint64_t n) {
  auto& queue = static_cast<Dual*>(handle)->queue;
  queue.insert(queue.end(), writes, writes + n);
}

uint64_t dual_queued(void* handle) { return static_cast<Dual*>(handle)->queue.size(); }

void dual_clock(void* handle, uint64_t clocks) {
  for (uint64_t i = 0; i < clocks; ++i) static_cast<Dual*>(handle)->clock();
}

uint64_t dual_clocks(void* handle) { return static_cast<Dual*>(handle)->clocks; }

// Bit 0: irq_o, bit 1: stop_o.
int dual_lines(void* handle) {
  auto* top = static_cast<Dual*>(handle)->top.get();
  return top->irq_o | top->stop_o << 1;
}

// Runs whole periods; returns how many, fewer if the system hangs.
uint64_t dual_run(void* handle, Period* periods, uint64_t n) {
  for (uint64_t i = 0; i < n; ++i)
    if (!static_cast<Dual*>(handle)->period(&periods[i])) return i;
  return n;
}

}  // extern "C"
