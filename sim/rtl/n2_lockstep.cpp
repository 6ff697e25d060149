// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated n2_core with its memories, an Avalon-MM memory with wait states, scripted
// interrupts and custom instructions, called from Python (n2_lockstep.py). Records every retired
// instruction. Custom instructions (numbers of this harness): see CustomUnit.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "Vn2_core.h"
#include "bench.h"

namespace {

constexpr uint32_t kItcmBytes = 1 << 16;   // as the parameters of the core
constexpr uint32_t kDtcmBytes = 1 << 16;
constexpr uint32_t kAvalonBytes = 1 << 16; // repeats over the whole Avalon space

// One retired instruction; all fields 32 bits, the layout is known to n2_lockstep.py.
struct Record {
  uint32_t cycle, pc, word, write, dst, value, exception, cause;
};

// Avalon-MM transfers, for tests of byte lanes and of accesses that must not happen.
struct Transfer {
  uint32_t cycle, write, address, byteenable, data;
};

struct Irq {
  uint32_t cycle, level;
};

// What a multicycle custom instruction of the test bench saw.
struct Start {
  uint32_t cycle, n, a, b, c, reads, dataa, datab;
};

// Multicycle custom instructions: n in 0..127 takes (n & 15) + 1 cycles, n >= 128 a random number of
// cycles up to 16. Result: dataa + 3 * datab + n; readra = 0 takes internal register a instead of
// dataa (readrb likewise), writerc = 0 stores into internal register c. State moves with clk_en only.
struct CustomUnit {
  uint32_t registers[32] = {};
  uint32_t left = 0;
  uint32_t random = 1;

  uint32_t next_random() {
    random = random * 1664525u + 1013904223u;
    return random >> 16;
  }
};

struct Core : Bench<Core, Vn2_core> {
  std::vector<uint32_t> itcm, dtcm, avalon;
  std::vector<Record> records;
  std::vector<Transfer> transfers;
  std::vector<Start> starts;
  std::vector<Irq> irqs;
  size_t next_irq = 0;
  CustomUnit custom;
  uint32_t cycle = 0;
  uint32_t wait_max = 0, wait_left = 0, wait_random = 1;
  bool waiting = false;
  uint32_t protocol_errors = 0;
  // Avalon request of the last cycle that was held: must not change.
  bool held = false;
  uint32_t held_address = 0, held_data = 0, held_lanes = 0;

  Core() {
    itcm.resize(kItcmBytes / 4);
    dtcm.resize(kDtcmBytes / 4);
    avalon.resize(kAvalonBytes / 4);
    top->ci_multi_done_i = 0;
    top->avm_waitrequest_i = 0;
    top->irq_i = 0;
    reset();
  }

  void reset() {
    top->irq_i = 0;
    top->rst_ni = 0;
    for (int i = 0; i < 3; ++i) {
      settle();
      rise();
    }
    top->rst_ni = 1;
    settle();
    records.clear();
    transfers.clear();
    starts.clear();
    irqs.clear();
    next_irq = 0;
    cycle = 0;
    waiting = held = false;
    custom = CustomUnit();
  }

  static uint32_t mask(uint32_t lanes) {
    uint32_t bits = 0;
    for (int i = 0; i < 4; ++i)
      if (lanes >> i & 1) bits |= 0xffu << 8 * i;
    return bits;
  }

  static uint32_t access(std::vector<uint32_t>& memory, uint32_t address, uint32_t lanes,
                         uint32_t data) {
    uint32_t& word = memory[address % memory.size()];
    const uint32_t old = word;
    word = (old & ~mask(lanes)) | (data & mask(lanes));
    return old;
  }

  void combinational() {
    const uint32_t n = top->ci_combo_n_o;
    top->ci_combo_result_i = (top->ci_combo_dataa_o ^ top->ci_combo_datab_o) + n;
  }

  // One clock cycle: inputs of the cycle, then the rising edge with what the memories answer.
  void clock() {
    while (next_irq < irqs.size() && irqs[next_irq].cycle <= cycle) top->irq_i = irqs[next_irq++].level;
    combinational();
    // Avalon.
    const bool request = top->avm_read_o || top->avm_write_o;
    if (request && !waiting) {
      waiting = true;
      wait_random = wait_random * 1664525u + 1013904223u;
      wait_left = wait_max ? (wait_random >> 16) % (wait_max + 1) : 0;
    }
    if (top->avm_read_o && top->avm_write_o) ++protocol_errors;
    if (held && (!request || top->avm_address_o != held_address ||
                 (top->avm_write_o && top->avm_writedata_o != held_data) ||
                 top->avm_byteenable_o != held_lanes))
      ++protocol_errors;
    top->avm_waitrequest_i = request && wait_left > 0;
    const uint32_t index = top->avm_address_o / 4 % avalon.size();
    top->avm_readdata_i = request && wait_left == 0 ? avalon[index] : 0xdeadbeef;
    // Multicycle custom instructions: none moves while a transfer holds the pipeline.
    if (request && top->ci_multi_clk_en_o) ++protocol_errors;
    if (top->ci_multi_start_o && !top->ci_multi_clk_en_o) ++protocol_errors;
    if (top->ci_multi_start_o) {
      const uint32_t n = top->ci_multi_n_o;
      if (custom.left) ++protocol_errors;
      custom.left = n >= 128 ? custom.next_random() % 16 + 1 : (n & 15) + 1;
      const uint32_t reads = top->ci_multi_readra_o << 2 | top->ci_multi_readrb_o << 1 |
                             top->ci_multi_writerc_o;
      starts.push_back({cycle, n, top->ci_multi_a_o, top->ci_multi_b_o, top->ci_multi_c_o, reads,
                        top->ci_multi_dataa_o, top->ci_multi_datab_o});
    }
    top->ci_multi_done_i = custom.left == 1;
    uint32_t result = 0xbadc0de;
    if (custom.left == 1) {
      const uint32_t a = top->ci_multi_readra_o ? top->ci_multi_dataa_o
                                                : custom.registers[top->ci_multi_a_o];
      const uint32_t b = top->ci_multi_readrb_o ? top->ci_multi_datab_o
                                                : custom.registers[top->ci_multi_b_o];
      result = a + 3 * b + top->ci_multi_n_o;
    }
    top->ci_multi_result_i = result;
    top->eval();
    combinational();
    top->eval();

    // What the memories take at the edge.
    const bool fetch = top->itcm_en_o, code = top->itcm_data_en_o, data = top->dtcm_en_o;
    const uint32_t fetch_address = top->itcm_address_o;
    uint32_t fetch_word = top->itcm_rdata_i, code_word = top->itcm_data_rdata_i,
             data_word = top->dtcm_rdata_i;
    if (fetch) fetch_word = itcm[fetch_address];
    if (code)
      code_word = access(itcm, top->itcm_data_address_o, top->itcm_data_we_o, top->itcm_data_wdata_o);
    if (data) data_word = access(dtcm, top->dtcm_address_o, top->dtcm_we_o, top->dtcm_wdata_o);
    held = request && wait_left > 0;
    held_address = top->avm_address_o;
    held_data = top->avm_writedata_o;
    held_lanes = top->avm_byteenable_o;
    if (request && wait_left == 0) {
      transfers.push_back({cycle, top->avm_write_o, top->avm_address_o, top->avm_byteenable_o,
                           top->avm_write_o ? top->avm_writedata_o : avalon[index]});
      if (top->avm_write_o) access(avalon, index, top->avm_byteenable_o, top->avm_writedata_o);
      waiting = false;
    } else if (request) {
      --wait_left;
    }
    if (custom.left && top->ci_multi_clk_en_o && --custom.left == 0 && !top->ci_multi_writerc_o)
      custom.registers[top->ci_multi_c_o] = result;
    if (top->trace_valid_o)
      records.push_back({cycle, top->trace_pc_o, top->trace_instruction_o, top->trace_write_o,
                         top->trace_dst_o, top->trace_value_o, top->trace_exception_o,
                         top->trace_cause_o});
    rise();
    top->itcm_rdata_i = fetch_word;
    top->itcm_data_rdata_i = code_word;
    top->dtcm_rdata_i = data_word;
    settle();
    ++cycle;
  }
};

}  // namespace

extern "C" {

void* n2_new() { return new Core; }
void n2_free(void* core) { delete static_cast<Core*>(core); }
void n2_reset(void* core) { static_cast<Core*>(core)->reset(); }

// Memory 0 instruction, 1 data, 2 Avalon: pointer to the first word; *words is the size.
uint32_t* n2_memory(void* core, uint32_t which, uint32_t* words) {
  Core& c = *static_cast<Core*>(core);
  std::vector<uint32_t>& memory = which == 0 ? c.itcm : which == 1 ? c.dtcm : c.avalon;
  *words = memory.size();
  return memory.data();
}

void n2_waits(void* core, uint32_t most, uint32_t seed) {
  Core& c = *static_cast<Core*>(core);
  c.wait_max = most;
  c.wait_random = seed;
}

// The interrupt lines take `level` from `cycle` (since reset) on; call in order of cycles.
void n2_irq(void* core, uint32_t cycle, uint32_t level) {
  static_cast<Core*>(core)->irqs.push_back({cycle, level});
}

// Runs until `records` instructions have left the pipeline, one at stop_pc among them, or `cycles`
// have passed in this call. Returns the number of records since reset.
uint32_t n2_run(void* core, uint32_t records, uint32_t cycles, uint32_t stop_pc) {
  Core& c = *static_cast<Core*>(core);
  while (cycles-- && c.records.size() < records) {
    c.clock();
    if (!c.records.empty() && c.records.back().pc == stop_pc) break;
  }
  return c.records.size();
}

uint32_t n2_records(void* core, uint32_t* words, uint32_t n) {
  return copy_events(static_cast<Core*>(core)->records, words, n);
}
uint32_t n2_transfers(void* core, uint32_t* words, uint32_t n) {
  return copy_events(static_cast<Core*>(core)->transfers, words, n);
}
uint32_t n2_starts(void* core, uint32_t* words, uint32_t n) {
  return copy_events(static_cast<Core*>(core)->starts, words, n);
}
uint32_t n2_protocol_errors(void* core) { return static_cast<Core*>(core)->protocol_errors; }
uint32_t n2_cycles(void* core) { return static_cast<Core*>(core)->top->cycles_o; }
uint32_t n2_retired(void* core) { return static_cast<Core*>(core)->top->retired_o; }
}
