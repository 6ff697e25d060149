// SPDX-License-Identifier: Apache-2.0
// Millions of encoder edges into the Verilated quadrature_decoder (decoder_edges.py): 25 million counts a
// second at 100 MHz are an edge in four clocks; each edge jitters by a clock either way, and the motion turns
// now and then. In every clock the count is compared with the true position a latency ago.
#include "Vquadrature_decoder.h"
#include "bench.h"

namespace {

constexpr uint32_t kFilter = 1, kLatency = 4 + kFilter, kRing = 8;  // clocks

struct Decoder : Bench<Decoder, Vquadrature_decoder> {
  int32_t position = 0, late[kRing] = {};
  uint64_t wrong = 0, row = 0;

  Decoder() {
    top->filter_i = kFilter;
    lines();
    reset(2, 8);
  }

  void lines() {
    const uint32_t quarter = position & 3;
    top->a_i = quarter == 1 || quarter == 2;
    top->b_i = quarter == 2 || quarter == 3;
  }

  // A clock with the lines as they are; counts a wrong position and an illegal transition.
  void step() {
    clock();
    late[row % kRing] = position;
    wrong += int32_t(top->position_o) != late[(row - kLatency + 1) % kRing] || top->illegal_o;
    ++row;
  }
};

}  // namespace

extern "C" {

// Clocks of `edges` edges in which the count or the flag was wrong.
__attribute__((visibility("default"))) uint64_t decoder_legal(uint64_t seed, uint64_t edges, uint64_t* clocks) {
  Decoder decoder;
  Random random(seed);
  int32_t way = 1;
  uint64_t slot = 4, at = 4;  // of the next edge; slots are four clocks apart
  for (uint64_t clock = 0; edges; ++clock) {
    if (clock == at) {
      decoder.position += way;
      decoder.lines();
      --edges;
      const uint32_t draw = random.draw();
      if (draw >> 24 == 0) way = -way;  // an edge in 256 is the last before a turn
      slot += 4;
      at = slot + draw % 3 - 1;  // two edges are two clocks apart at least
    }
    decoder.step();
  }
  for (uint32_t n = 0; n < kRing; ++n) decoder.step();
  *clocks = decoder.clocks;
  return decoder.wrong;
}

// Of `planted` changes of both lines in one clock, between legal edges: those that were not flagged and
// counted, or moved the position.
__attribute__((visibility("default"))) uint64_t decoder_illegal(uint64_t seed, uint64_t planted) {
  Decoder decoder;
  Random random(seed);
  uint64_t missed = 0;
  int32_t offset = 0;  // a change of both lines is two counts that are lost
  for (uint64_t n = 0; n < planted; ++n) {
    for (uint32_t edge = random.draw() % 5; edge; --edge) {
      decoder.position += random.draw() & 1 ? 1 : -1;
      decoder.lines();
      for (uint32_t k = 0; k < 4; ++k) decoder.clock();
    }
    for (uint32_t k = 0; k < kRing; ++k) decoder.clock();
    const int32_t before = decoder.top->position_o;
    decoder.position += 2;
    offset += 2;
    decoder.lines();
    for (uint32_t k = 0; k < kRing; ++k) decoder.clock();
    missed += !decoder.top->illegal_o || decoder.top->illegal_count_o != 1 ||
              int32_t(decoder.top->position_o) != before || before != decoder.position - offset;
    decoder.top->clear_i = 1;
    decoder.clock();
    decoder.top->clear_i = 0;
    decoder.clock();
    missed += decoder.top->illegal_o;
  }
  return missed;
}

}  // extern "C"
