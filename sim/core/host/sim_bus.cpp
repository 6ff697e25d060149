// SPDX-License-Identifier: Apache-2.0
// sim_bus: Avalon-MM host in front of the Verilated core.
#include "sim_bus.h"

#include <cstdio>
#include <cstdlib>

#include "../../rtl/bench.h"
#include "Vasip.h"

namespace {

struct Core : Bench<Core, Vasip> {
  Core() { reset(); }

  uint32_t word(uint32_t address, uint32_t data, bool write) {
    if (access(address, &data, write)) return data;
    std::fprintf(stderr, "bus access of word %#x was never answered\n", address);
    std::exit(3);
  }
};

Core& core() {
  static Core instance;
  return instance;
}

}  // namespace

uint32_t sim_read32(void*, uint32_t address) { return core().word(address, 0, false); }

void sim_write32(void*, uint32_t address, uint32_t data) { core().word(address, data, true); }

int sim_irq(void) {
  core().settle();
  return core().top->irq_o;
}
