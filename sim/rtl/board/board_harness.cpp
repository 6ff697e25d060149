// SPDX-License-Identifier: Apache-2.0
// A Verilated board top: clock, button, serial line, step and direction, encoders.
// The build sets BOARD to the model's class and clk_i, rst_ni, rx_i, tx_o to the names of the board's pins.
#define QUOTED(x) #x
#define HEADER(x) QUOTED(x.h)
#include HEADER(BOARD)
#include "bench.h"
#include "serial_line.h"

namespace {

struct Board : Bench<Board, BOARD> {
  Line line;

  Board() { reset(); }

  void edge() {
    line.watch(top->tx_o);
    top->rx_i = line.drive();
    rise();
  }
};

}  // namespace

extern "C" {

void* board_new() { return new Board; }
void board_free(void* handle) { delete static_cast<Board*>(handle); }

void board_clock(void* handle, uint32_t cycles) {
  for (uint32_t i = 0; i < cycles; ++i) static_cast<Board*>(handle)->clock();
}

void board_button(void* handle, int down) { static_cast<Board*>(handle)->top->rst_ni = !down; }

void board_encoders(void* handle, uint32_t a, uint32_t b, uint32_t z) {
  auto& top = *static_cast<Board*>(handle)->top;
  top.encoder_a = a;
  top.encoder_b = b;
  top.encoder_z = z;
}

uint32_t board_step(void* handle) { return static_cast<Board*>(handle)->top->step; }
uint32_t board_direction(void* handle) { return static_cast<Board*>(handle)->top->direction; }

void board_line_divider(void* handle, uint32_t divider) { static_cast<Board*>(handle)->line.divider = divider; }

void board_line_send(void* handle, const char* bytes, uint32_t n) { static_cast<Board*>(handle)->line.send(bytes, n); }

uint32_t board_line_receive(void* handle, char* bytes, uint32_t n) {
  return static_cast<Board*>(handle)->line.receive(bytes, n);
}

}  // extern "C"
