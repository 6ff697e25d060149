// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated ci_bench: plays the CPU towards custom instructions, called from Python
// (tests/custom/ci_bench.py). One call runs many instructions.
#include <cstdint>

#include "Vci_bench.h"
#include "bench.h"

namespace {

constexpr uint32_t kTimeout = 200;  // enabled cycles of an instruction that never ends

struct Instruction {
  uint32_t select, n, dataa, datab;
  uint32_t fields;  // {writerc, readrb, readra, c, b, a} from bit 17 down
};

struct Outcome {
  uint32_t result;
  uint32_t cycles;  // enabled cycles, start included; 0: never done
};

struct Cpu : Bench<Cpu, Vci_bench> {
  Random random;

  Cpu() {
    top->start_i = 0;
    top->clk_en_i = 1;
    reset();
  }

  void edge() {
    rise();
    settle();
  }

  void reset() {
    top->reset_i = 1;
    top->eval();
    edge();
    top->reset_i = 0;
    top->eval();
  }

  void drive(const Instruction& op) {
    top->select_i = op.select;
    top->n_i = op.n;
    top->dataa_i = op.dataa;
    top->datab_i = op.datab;
    top->a_i = op.fields & 31;
    top->b_i = op.fields >> 5 & 31;
    top->c_i = op.fields >> 10 & 31;
    top->readra_i = op.fields >> 15 & 1;
    top->readrb_i = op.fields >> 16 & 1;
    top->writerc_i = op.fields >> 17 & 1;
  }

  // The pins of an idle CPU carry anything, but no start.
  void idle(uint32_t select) {
    top->start_i = 0;
    const uint32_t fields = random.draw();
    drive({select, random.draw() & 255, random.draw(), random.draw(), fields});
    top->clk_en_i = random.draw() & 1;
    top->eval();
    edge();
  }

  // One instruction as the CPU gives it: start in the first enabled cycle, operands held, the result
  // taken at the enabled edge that ends cycle `fixed`, or with `fixed` 0 the cycle with done.
  Outcome run(const Instruction& op, uint32_t fixed, uint32_t stalls) {
    drive(op);
    top->start_i = 1;
    for (uint32_t cycle = 1; cycle <= kTimeout;) {
      top->clk_en_i = (random.draw() & 255) >= stalls;
      top->eval();
      const bool last = fixed ? cycle == fixed : top->done_o;
      const uint32_t result = top->result_o;
      const bool enabled = top->clk_en_i;
      edge();
      if (!enabled) continue;
      top->start_i = 0;
      top->eval();
      if (last) return {result, cycle};
      ++cycle;
    }
    top->start_i = 0;
    return {0, 0};
  }
};

}  // namespace

extern "C" {

void* ci_new() { return new Cpu; }
void ci_free(void* bench) { delete static_cast<Cpu*>(bench); }

void ci_run(void* handle, const Instruction* ops, uint32_t count, uint32_t fixed, uint32_t stalls,
            uint32_t gaps, uint64_t seed, Outcome* outcomes) {
  Cpu& bench = *static_cast<Cpu*>(handle);
  bench.random = Random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    outcomes[i] = bench.run(ops[i], fixed, stalls);
    for (uint32_t k = gaps ? bench.random.draw() % (gaps + 1) : 0; k; --k) bench.idle(ops[i].select);
  }
  bench.top->clk_en_i = 1;
}

// Starts an instruction, lets `cycles` enabled cycles pass, then resets.
void ci_abandon(void* handle, const Instruction* op, uint32_t cycles) {
  Cpu& bench = *static_cast<Cpu*>(handle);
  bench.drive(*op);
  bench.top->start_i = 1;
  bench.top->clk_en_i = 1;
  for (uint32_t k = 0; k < cycles; ++k) {
    bench.top->eval();
    bench.edge();
    bench.top->start_i = 0;
  }
  bench.top->start_i = 0;
  bench.reset();
}

// done_o with no start, over `cycles` enabled cycles: how many of them show it.
uint32_t ci_done_when_idle(void* handle, const Instruction* op, uint32_t cycles) {
  Cpu& bench = *static_cast<Cpu*>(handle);
  bench.drive(*op);
  bench.top->start_i = 0;
  bench.top->clk_en_i = 1;
  uint32_t seen = 0;
  for (uint32_t k = 0; k < cycles; ++k) {
    bench.top->eval();
    seen += bench.top->done_o;
    bench.edge();
  }
  return seen;
}

// Combinational outputs {fcmp, fsign, platform 1, platform 2} per instruction.
void ci_combinational(void* handle, const Instruction* ops, uint32_t count, uint32_t* outputs) {
  Cpu& bench = *static_cast<Cpu*>(handle);
  for (uint32_t i = 0; i < count; ++i) {
    bench.drive(ops[i]);
    bench.top->eval();
    outputs[4 * i + 0] = bench.top->fcmp_o;
    outputs[4 * i + 1] = bench.top->fsign_o;
    outputs[4 * i + 2] = bench.top->combo1_o;
    outputs[4 * i + 3] = bench.top->combo2_o;
  }
}

}  // extern "C"
