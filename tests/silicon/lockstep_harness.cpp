// SPDX-License-Identifier: Apache-2.0
// Runs a pair of modules with the same random inputs and looks for the first clock in which they differ.
// The build sets MODEL to the class of the wrapper that lockstep.py writes.
#define QUOTED(x) #x
#define HEADER(x) QUOTED(x.h)
#include HEADER(MODEL)
#include "bench.h"

namespace {
constexpr int HELD = 64;  // clocks of the reset: pipelines without one are full of the inputs after it

struct Pair : Bench<Pair, MODEL> {};
}  // namespace

// Each of `ports` inputs, `bits` wide one after the other in stimulus_i, keeps its value in half of the
// clocks, else it is random, all ones or all zeros.
// Returns the first clock with a difference, -1 if there is none; moved: `words` words of the first module's
// outputs, 1 where a bit changed.
extern "C" int64_t lockstep_run(uint64_t seed, uint64_t clocks, uint32_t ports, const uint32_t* bits,
                                uint32_t words, uint32_t* moved) {
  Pair pair;
  Random random(seed);
  auto* inputs = reinterpret_cast<uint32_t*>(&pair.top->stimulus_i);
  pair.reset(HELD);
  int64_t first = -1;
  for (uint64_t n = 0; n < clocks && first < 0; ++n) {
    uint32_t at = 0;
    for (uint32_t p = 0; p < ports; at += bits[p++]) {
      const uint32_t choice = random.draw() & 15;
      if (choice < 8) continue;
      uint32_t word = 0;
      for (uint32_t b = 0; b < bits[p]; ++b) {
        if (b % 32 == 0) word = choice == 8 ? 0 : choice == 9 ? ~0u : random.draw();
        const uint32_t place = at + b;
        inputs[place / 32] = (inputs[place / 32] & ~(1u << place % 32)) | (word >> b % 32 & 1) << place % 32;
      }
    }
    pair.settle();
    if (pair.top->differs_o) first = n;
    pair.edge();
  }
  std::memcpy(moved, &pair.top->moved_o, 4 * words);
  return first;
}
