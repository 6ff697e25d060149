// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated ASIP: bus accesses, whole runs and traces, called from Python (asip_rtl.py).
// One call does all the bus traffic of one or many control ticks, so that Python is not in the clock loop.
#include <algorithm>
#include <cstdint>

#include <string>

#ifdef DEBUG_BLOCK
#include "Vdebug_asip.h"
using Model = Vdebug_asip;
#else
#include "Vasip.h"
using Model = Vasip;
#endif
#include "bench.h"
#ifdef DEBUG_BLOCK
#include "serial_line.h"
#endif

namespace {

constexpr uint64_t kRunTimeout = 1000000;  // clocks; a longer run never ends

struct Issue {
  uint32_t cycle;  // since the trace began
  uint32_t address;
};

struct Write {
  uint32_t cycle;
  uint32_t bank;  // 0..2: A, B, C; 3: output
  uint32_t index;
  uint32_t data;
};

struct Asip : Bench<Asip, Model> {
#ifdef DEBUG_BLOCK
  Line line;
#endif
  std::vector<uint64_t> issued;  // bundles issued per program address
  bool tracing = false;
  uint64_t trace_start = 0;
  std::vector<Issue> issues;
  std::vector<Write> writes;

  Asip() : issued(1 << 16, 0) { restart(); }

  void edge() {
#ifdef DEBUG_BLOCK
    line.watch(top->tx_o);
    top->rx_i = line.drive();
#endif
    if (top->trace_issue_o) ++issued[top->trace_pc_o];
    if (tracing) trace();
    rise();
  }

  void trace() {
    const uint32_t cycle = clocks - trace_start;
    if (top->trace_issue_o) issues.push_back({cycle, top->trace_pc_o});
    const uint32_t valid = top->trace_write_o;
    for (uint32_t bank = 0; bank < 3; ++bank) {
      if (valid >> bank & 1) {
        const uint32_t index = top->trace_index_o >> (6 * bank) & 63;
        writes.push_back({cycle, bank, index, top->trace_data_o[bank]});
      }
    }
    if (valid >> 3 & 1) {
      writes.push_back({cycle, 3, top->trace_index_o >> 12 & 63, top->trace_data_o[2]});
    }
  }

  void restart() {
    top->read_i = 0;
    top->write_i = 0;
    top->address_i = 0;
    top->writedata_i = 0;
    reset();
  }
};

}  // namespace

extern "C" {

void* asip_new() { return new Asip; }
void asip_free(void* handle) { delete static_cast<Asip*>(handle); }
void asip_reset(void* handle) { static_cast<Asip*>(handle)->restart(); }

int asip_write(void* handle, uint32_t address, uint32_t data) {
  return static_cast<Asip*>(handle)->access(address, &data, true);
}

int asip_read(void* handle, uint32_t address, uint32_t* data) {
  return static_cast<Asip*>(handle)->access(address, data, false);
}

void asip_clock(void* handle, uint32_t cycles) {
  for (uint32_t i = 0; i < cycles; ++i) static_cast<Asip*>(handle)->clock();
}

int asip_irq(void* handle) { return static_cast<Asip*>(handle)->top->irq_o; }
uint64_t asip_cycles(void* handle) { return static_cast<Asip*>(handle)->clocks; }

// Bundles issued per program address since asip_new, n entries.
void asip_issued(void* handle, uint64_t* counts, uint32_t n) {
  std::memcpy(counts, static_cast<Asip*>(handle)->issued.data(), n * sizeof(uint64_t));
}

void asip_trace(void* handle, int on) {
  auto* asip = static_cast<Asip*>(handle);
  asip->tracing = on != 0;
  asip->trace_start = asip->clocks;
  asip->issues.clear();
  asip->writes.clear();
}

// Copy at most n traced issues (cycle, address) or writes (cycle, bank, index, data); return how many there are.
uint32_t asip_trace_issues(void* handle, uint32_t* pairs, uint32_t n) {
  return copy_events(static_cast<Asip*>(handle)->issues, pairs, n);
}

uint32_t asip_trace_writes(void* handle, uint32_t* quadruples, uint32_t n) {
  return copy_events(static_cast<Asip*>(handle)->writes, quadruples, n);
}

// Runs `ticks` control ticks as a host would: write `writes` words, start, wait for the interrupt, read
// `reads` words; `clear` and `start` are words of CONTROL. status_cycles gets two words per tick: STATUS and CYCLES. Stops after a tick whose status has
// the fault bit. Interrupts must be enabled. Returns the number of ticks done, or -1 if the bus or core hangs.
int64_t asip_run(void* handle, uint32_t ticks, const uint32_t* write_address, uint32_t writes,
                 const uint32_t* write_data, const uint32_t* read_address, uint32_t reads,
                 uint32_t* read_data, uint32_t* status_cycles, uint32_t control, uint32_t status,
                 uint32_t cycles, uint32_t fault_mask, uint32_t clear, uint32_t start) {
  auto* asip = static_cast<Asip*>(handle);
  for (uint32_t tick = 0; tick < ticks; ++tick) {
    for (uint32_t i = 0; i < writes; ++i) {
      uint32_t word = write_data[size_t(tick) * writes + i];
      if (!asip->access(write_address[i], &word, true)) return -1;
    }
    if (!asip->access(control, &clear, true) || !asip->access(control, &start, true)) return -1;
    uint64_t waited = 0;
    while (!asip->top->irq_o) {
      asip->clock();
      if (++waited > kRunTimeout) return -1;
    }
    uint32_t* sc = status_cycles + size_t(tick) * 2;
    if (!asip->access(status, &sc[0], false) || !asip->access(cycles, &sc[1], false)) return -1;
    for (uint32_t i = 0; i < reads; ++i) {
      if (!asip->access(read_address[i], &read_data[size_t(tick) * reads + i], false)) return -1;
    }
    if (sc[0] & fault_mask) return tick + 1;
  }
  return ticks;
}

#ifdef DEBUG_BLOCK
int asip_debug_active(void* handle) { return static_cast<Asip*>(handle)->top->debug_active_o; }

void asip_line_divider(void* handle, uint32_t divider) { static_cast<Asip*>(handle)->line.divider = divider; }

void asip_line_send(void* handle, const char* bytes, uint32_t n) {
  static_cast<Asip*>(handle)->line.send(bytes, n);
}

// At most n bytes that have come; returns how many.
uint32_t asip_line_receive(void* handle, char* bytes, uint32_t n) {
  return static_cast<Asip*>(handle)->line.receive(bytes, n);
}
#endif

}  // extern "C"
