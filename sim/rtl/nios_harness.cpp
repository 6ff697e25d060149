// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated Nios II systems: memories, control ticks, programs and a profile, called
// from Python (nios_rtl.py). One call runs many control ticks, so that Python is not in the clock loop.
#include <cstdint>
#include <string>

#include "Vn2_system.h"
#include "Vn2_system___024root.h"
#include "bench.h"

namespace {

constexpr uint32_t kBreak1 = 0x003DA07A;

// An instruction that left stage A, with the first cycle of each stage; the same layout in nios_rtl.py.
struct Step {
  uint64_t decode, execute, memory, align, end;
  uint32_t pc, word, value, flags;  // flags: 1 value goes to register flags >> 8, 2 an exception
};

struct Nios : Bench<Nios, Vn2_system> {
  std::string console;
  bool exited = false;
  uint32_t exit_status = 0;
  uint32_t r5 = 0;  // last value written to r5
  uint32_t pc = 0;  // of the last instruction completed
  // Guard: loads and stores (a bit for each OP, 0: no guard) outside of the ranges first .. end stray.
  uint64_t accessing = 0;
  std::vector<uint32_t> ranges;
  uint32_t registers[32] = {};
  bool stray = false;
  uint32_t stray_address = 0;
  // Profile: cycles and completions per word of the instruction memory, between start and end of a tick.
  bool profiling = false;
  bool always = false;  // profile outside of ticks too
  uint32_t code_base = 0;
  uint64_t last_record = 0;
  std::vector<uint64_t> spent, completed;
  // Trace: the instructions after the first `skipped`, at most `room` of them.
  uint64_t skipped = 0, room = 0;
  bool decoding = false;  // `in_d` is the first cycle of the instruction in D
  uint64_t in_d = 0;
  Step in_e{}, in_m{}, in_a{}, leaving{};
  std::vector<Step> steps;

  Nios() {
    top->run_i = 0;
    top->enable_i = 0;
    top->tick_i = 0;
    top->host_write_i = 0;
    top->host_address_i = 0;
    top->host_wdata_i = 0;
    top->debug_read_i = 0;
    top->debug_write_i = 0;
    reset();
  }

  void edge() {
    if (top->console_valid_o) console.push_back(static_cast<char>(top->console_data_o));
    if (top->exit_valid_o && !exited) {
      exited = true;
      exit_status = top->exit_status_o;
    }
    if (top->trace_valid_o) retire();
    if (room) follow();
    // Instructions of a debugger write registers too, and are not valid in the trace.
    if (top->trace_write_o && (top->trace_valid_o || top->debug_halted_o)) {
      registers[top->trace_dst_o] = top->trace_value_o;
    }
    rise();
  }

  // `break 1` with r4 = 0 asks a debugger to end the program, status r5 (nios_sw/lib/exit_semihost.S).
  void retire() {
    pc = top->trace_pc_o;
    if (accessing) guard();
    if (top->trace_write_o && top->trace_dst_o == 5) r5 = top->trace_value_o;
    if (top->trace_instruction_o == kBreak1 && !exited) {
      exited = true;
      exit_status = r5;
    }
    if (profiling) record();
    if (room) trace();
  }

  // Moves the first cycles along with their instructions, in the cycle before the edge.
  void follow() {
    const auto* core = top->rootp;
    if (core->n2_system__DOT__u_core__DOT__valid_d && !decoding) {
      decoding = true;
      in_d = clocks;
    }
    if (!core->n2_system__DOT__u_core__DOT__en) return;
    leaving = in_a;
    leaving.end = clocks + 1;
    in_a = in_m;
    in_a.align = clocks + 1;
    in_m = in_e;
    in_m.memory = clocks + 1;
    in_e.decode = in_d;
    in_e.execute = clocks + 1;
    const bool issue = core->n2_system__DOT__u_core__DOT__issue_d;
    const bool lost = core->n2_system__DOT__u_core__DOT__jump_e || core->n2_system__DOT__u_core__DOT__redirect_m_q;
    if (issue || lost) decoding = false;
  }

  // The record of an instruction comes in the cycle after it has left A.
  void trace() {
    if (skipped) {
      --skipped;
    } else if (steps.size() < room) {
      leaving.pc = top->trace_pc_o;
      leaving.word = top->trace_instruction_o;
      leaving.value = top->trace_value_o;
      leaving.flags = top->trace_write_o | top->trace_exception_o << 1 | top->trace_dst_o << 8;
      steps.push_back(leaving);
    }
  }

  void guard() {
    const uint32_t word = top->trace_instruction_o;
    if (accessing >> (word & 63) & 1 && !top->trace_exception_o) {
      const uint32_t address = registers[word >> 27] + int16_t(word >> 6);
      stray = true;
      for (size_t i = 0; i < ranges.size(); i += 2) {
        if (address >= ranges[i] && address < ranges[i + 1]) stray = false;
      }
      stray_address = address;
    }
  }

  // The cycles since the previous instruction left the pipeline belong to the one that leaves it now.
  void record() {
    const uint64_t delta = clocks - last_record;
    last_record = clocks;
    const uint32_t word = (top->trace_pc_o - code_base) / 4;
    if ((always || top->pending_o) && word < spent.size()) {
      spent[word] += delta;
      ++completed[word];
    }
  }

  void host(uint32_t address, bool write, uint32_t data) {
    top->host_address_i = address;
    top->host_write_i = write;
    top->host_wdata_i = data;
    clock();
    top->host_write_i = 0;
  }

  // Read data follow the address by one cycle.
  uint32_t read(uint32_t address) {
    host(address, false, 0);
    settle();
    return top->host_rdata_o;
  }

  // One access to the debug module, with its wait states.
  void debug(uint32_t address, uint32_t* data, bool write) {
    top->debug_address_i = address;
    top->debug_writedata_i = write ? *data : 0;
    top->debug_write_i = write;
    top->debug_read_i = !write;
    bool waits = true;
    while (waits) {
      settle();
      waits = top->debug_waitrequest_o;
      if (!waits && !write) *data = top->debug_readdata_o;
      edge();
    }
    top->debug_write_i = 0;
    top->debug_read_i = 0;
  }
};

// Access to the debug module; the same layout in nios_rtl.py.
struct DebugAccess {
  uint32_t address, write, data;
};

}  // namespace

extern "C" {

void* nios_new() { return new Nios; }
void nios_free(void* handle) { delete static_cast<Nios*>(handle); }
uint64_t nios_cycles(void* handle) { return static_cast<Nios*>(handle)->clocks; }
uint32_t nios_pc(void* handle) { return static_cast<Nios*>(handle)->pc; }
uint32_t nios_overrun(void* handle) { return static_cast<Nios*>(handle)->top->overrun_o; }
uint32_t nios_retired(void* handle) { return static_cast<Nios*>(handle)->top->retired_o; }

void nios_write(void* handle, uint32_t address, const uint32_t* words, uint32_t n) {
  for (uint32_t i = 0; i < n; ++i) static_cast<Nios*>(handle)->host(address + 4 * i, true, words[i]);
}

void nios_read(void* handle, uint32_t address, uint32_t* words, uint32_t n) {
  for (uint32_t i = 0; i < n; ++i) words[i] = static_cast<Nios*>(handle)->read(address + 4 * i);
}

// Releases or holds the reset of the core; enable is the host's wish for control.
void nios_run(void* handle, uint32_t run, uint32_t enable) {
  auto* nios = static_cast<Nios*>(handle);
  // Not before the start: the last program may end again until its reset has arrived.
  if (run && !nios->top->run_i) nios->exited = false;
  nios->top->run_i = run;
  nios->top->enable_i = enable;
  nios->clock();
}

void nios_clock(void* handle, uint32_t cycles) {
  for (uint32_t i = 0; i < cycles; ++i) static_cast<Nios*>(handle)->clock();
}

// Starts a control tick and does not wait.
void nios_tick(void* handle) {
  auto* nios = static_cast<Nios*>(handle);
  nios->top->tick_i = 1;
  nios->clock();
  nios->top->tick_i = 0;
}

// Watches the accesses of the program, of registers that are zero at its start; n words in `ranges`.
void nios_guard(void* handle, uint64_t accessing, const uint32_t* ranges, uint32_t n) {
  auto* nios = static_cast<Nios*>(handle);
  nios->accessing = accessing;
  nios->ranges.assign(ranges, ranges + n);
  nios->stray = false;
}

// The stray access, if there was one: 1 and its address.
int nios_stray(void* handle, uint32_t* address) {
  auto* nios = static_cast<Nios*>(handle);
  *address = nios->stray_address;
  return nios->stray;
}

// Runs until the program ends: 1 and its status, or 0 after `limit` cycles or at a stray access.
int nios_execute(void* handle, uint64_t limit, uint32_t* status) {
  auto* nios = static_cast<Nios*>(handle);
  for (uint64_t i = 0; i < limit && !nios->exited && !nios->stray; ++i) nios->clock();
  *status = nios->exit_status;
  return nios->exited;
}

// Accesses to the debug module, one after the other; `data` of reads is filled.
void nios_debug(void* handle, DebugAccess* accesses, uint32_t n) {
  for (uint32_t i = 0; i < n; ++i) {
    static_cast<Nios*>(handle)->debug(accesses[i].address, &accesses[i].data, accesses[i].write);
  }
}

uint32_t nios_halted(void* handle) { return static_cast<Nios*>(handle)->top->debug_halted_o; }

// Runs until a debugger's halt: 1, or 0 after `limit` cycles or when the program has just ended.
int nios_until_halt(void* handle, uint64_t limit) {
  auto* nios = static_cast<Nios*>(handle);
  const bool ended = nios->exited;
  nios->stray = false;
  for (uint64_t i = 0; i < limit && nios->exited == ended && !nios->stray && !nios->top->debug_halted_o; ++i) {
    nios->clock();
  }
  // The break's own record is yet to come: `break 1` is an end too.
  for (int i = 0; i < 4 && nios->top->debug_halted_o; ++i) nios->clock();
  return nios->top->debug_halted_o;
}

// The end of the program, if it came: 1 and its status.
int nios_ended(void* handle, uint32_t* status) {
  auto* nios = static_cast<Nios*>(handle);
  *status = nios->exit_status;
  return nios->exited;
}

// Text of the console so far, at most n bytes; returns its length.
uint32_t nios_console(void* handle, char* text, uint32_t n) {
  const std::string& console = static_cast<Nios*>(handle)->console;
  if (n > console.size()) n = console.size();
  std::memcpy(text, console.data(), n);
  return console.size();
}

void nios_console_clear(void* handle) { static_cast<Nios*>(handle)->console.clear(); }

// Starts the profile of the words code_base .. code_base + 4 n; whole: also outside of control ticks.
void nios_profile(void* handle, uint32_t code_base, uint32_t n, uint32_t whole) {
  auto* nios = static_cast<Nios*>(handle);
  nios->profiling = n != 0;
  nios->always = whole != 0;
  nios->code_base = code_base;
  nios->last_record = nios->clocks;
  nios->spent.assign(n, 0);
  nios->completed.assign(n, 0);
}

void nios_profile_read(void* handle, uint64_t* spent, uint64_t* completed) {
  auto* nios = static_cast<Nios*>(handle);
  std::memcpy(spent, nios->spent.data(), nios->spent.size() * sizeof(uint64_t));
  std::memcpy(completed, nios->completed.data(), nios->completed.size() * sizeof(uint64_t));
}

// Starts a trace of `n` instructions after the first `skip`.
void nios_trace(void* handle, uint64_t skip, uint64_t n) {
  auto* nios = static_cast<Nios*>(handle);
  nios->skipped = skip;
  nios->room = n;
  nios->decoding = false;
  nios->steps.clear();
}

// Number of instructions in the trace, which fill `steps` unless that is null.
uint64_t nios_traced(void* handle, Step* steps) {
  const auto& found = static_cast<Nios*>(handle)->steps;
  if (steps) std::memcpy(steps, found.data(), found.size() * sizeof(Step));
  return found.size();
}

// Runs `ticks` control ticks: `inputs` words to input_base, a tick, wait for its end, `outputs` words from
// output_base, then the words at `extra` addresses. cycles gets TICK_CYCLES of each tick. Returns the ticks
// done; fewer than requested when one takes more than `limit` cycles or the program ends.
uint32_t nios_ticks(void* handle, uint32_t ticks, uint32_t input_base, uint32_t inputs,
                    const uint32_t* input_words, uint32_t output_base, uint32_t outputs,
                    uint32_t* output_words, const uint32_t* extra, uint32_t extras,
                    uint32_t* extra_words, uint32_t* cycles, uint64_t limit) {
  auto* nios = static_cast<Nios*>(handle);
  for (uint32_t tick = 0; tick < ticks; ++tick) {
    nios_write(handle, input_base, input_words + size_t(tick) * inputs, inputs);
    nios_tick(handle);
    uint64_t waited = 0;
    do {
      nios->clock();
      if (++waited > limit || nios->exited) return tick;
    } while (nios->top->pending_o);
    cycles[tick] = nios->top->tick_cycles_o;
    nios_read(handle, output_base, output_words + size_t(tick) * outputs, outputs);
    for (uint32_t i = 0; i < extras; ++i) {
      extra_words[size_t(tick) * extras + i] = nios->read(extra[i]);
    }
  }
  return ticks;
}

}  // extern "C"
