// SPDX-License-Identifier: Apache-2.0
// sim_bus: Avalon-MM host in front of the Verilated core.
#include "sim_bus.h"

#include <cstdio>
#include <cstdlib>

#include "Vasip.h"
#include "verilated.h"

namespace {

constexpr int kBusTimeout = 1000000;  // cycles

struct Core {
  VerilatedContext context;
  Vasip top{&context};

  Core() {
    top.rst_ni = 0;
    for (int i = 0; i < 4; ++i) clock();
    top.rst_ni = 1;
    clock();
  }

  void settle() {
    top.clk_i = 0;
    top.eval();
  }

  void edge() {
    top.clk_i = 1;
    top.eval();
  }

  void clock() {
    settle();
    edge();
  }

  uint32_t access(uint32_t address, uint32_t data, bool write) {
    top.address_i = address;
    top.writedata_i = data;
    top.write_i = write;
    top.read_i = !write;
    for (int i = 0; i < kBusTimeout; ++i) {
      settle();
      const bool accepted = !top.waitrequest_o;
      const uint32_t word = top.readdata_o;
      edge();
      if (accepted) {
        top.write_i = 0;
        top.read_i = 0;
        return word;
      }
    }
    std::fprintf(stderr, "bus access of word %#x was never answered\n", address);
    std::exit(3);
  }
};

Core& core() {
  static Core instance;
  return instance;
}

}  // namespace

uint32_t sim_read32(void*, uint32_t address) { return core().access(address, 0, false); }

void sim_write32(void*, uint32_t address, uint32_t data) { core().access(address, data, true); }

int sim_irq(void) {
  core().settle();
  return core().top.irq_o;
}
