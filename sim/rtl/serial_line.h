// SPDX-License-Identifier: Apache-2.0
// A serial line of 8 data bits, no parity, one stop bit, at the pins of a Verilated model.
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>

// A serial line: bytes to and from the pins, so many clocks a bit.
struct Line {
  uint32_t divider = 868;
  std::string out, in;  // to the core, from it
  uint32_t out_bit = 0, out_clock = 0, in_bit = 0, in_clock = 0, in_byte = 0;
  size_t sent = 0;

  int drive() {  // level of rx_i in this clock
    if (sent == out.size()) return 1;
    const uint32_t frame = uint32_t(uint8_t(out[sent])) << 1 | 0x200;
    const int level = frame >> out_bit & 1;
    if (++out_clock == divider) {
      out_clock = 0;
      if (++out_bit == 10) {
        out_bit = 0;
        ++sent;
      }
    }
    return level;
  }

  void watch(int level) {  // of tx_o
    if (in_bit == 0) {
      if (level) return;
      in_bit = 1;
      in_clock = divider / 2;
    }
    if (in_clock--) return;
    in_clock = divider - 1;
    if (in_bit == 10) {
      if (level) in.push_back(char(in_byte));
      in_bit = 0;
      return;
    }
    if (in_bit > 1) in_byte = in_byte >> 1 | uint32_t(level) << 7;
    ++in_bit;
  }

  // Bytes after those that wait.
  void send(const char* bytes, uint32_t n) {
    out.erase(0, sent);
    sent = 0;
    out.append(bytes, n);
  }

  // At most n bytes that have come; returns how many.
  uint32_t receive(char* bytes, uint32_t n) {
    n = std::min<uint32_t>(n, in.size());
    in.copy(bytes, n);
    in.erase(0, n);
    return n;
  }
};
