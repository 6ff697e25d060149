// SPDX-License-Identifier: Apache-2.0
// Slaves in a line from a master's port, each with its own clock: wires of MII with a delay between them, an event at
// a time. A master may listen at the far end too, so that the line is a ring. Times are in ps.
//
// Model: a Verilated top with the MII ports of ethercat_slave.
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <queue>
#include <vector>

#include "bench.h"

constexpr uint64_t CLOCK_PS = 10000;      // a slave's, at 0 ppm
constexpr uint64_t NIBBLE_PS = 40000;     // the master's
constexpr unsigned CLOCKS_PER_NIBBLE = 4;
constexpr unsigned GAP_NIBBLES = 24;      // between frames, at least
constexpr unsigned PREAMBLE_NIBBLES = 15;

struct Nibble {
  bool valid, error;
  uint8_t data;
};

// What a port's receiver sees: its data, then in the middle of them the rising clock.
struct WireEvent {
  uint64_t time;
  bool rise;
  Nibble nibble;
};

struct Frame {
  uint64_t began, ended;       // first nibble of the preamble, after the last nibble
  std::vector<uint8_t> nibbles;  // after the start delimiter
  unsigned preamble;
};

// CRC-32 of IEEE 802.3, 3.2.9.
inline uint32_t check_sequence(const uint8_t* bytes, size_t n) {
  uint32_t state = ~0u;
  for (size_t i = 0; i < n; ++i) {
    state ^= bytes[i];
    for (int k = 0; k < 8; ++k) state = state >> 1 ^ (state & 1 ? 0xEDB88320u : 0);
  }
  return ~state;
}

// What goes onto the wire for a frame without check sequence: padded to the least length, checked.
inline std::vector<uint8_t> nibbles_of(const uint8_t* frame, size_t n) {
  std::vector<uint8_t> bytes(frame, frame + n);
  bytes.resize(std::max<size_t>(n, 60));
  const uint32_t check = check_sequence(bytes.data(), bytes.size());
  for (int i = 0; i < 4; ++i) bytes.push_back(check >> 8 * i);
  std::vector<uint8_t> nibbles;
  for (const uint8_t byte : bytes) {
    nibbles.push_back(byte & 0xF);
    nibbles.push_back(byte >> 4);
  }
  return nibbles;
}

// A frame without its check sequence; empty if it is short, ends within a byte, or the sequence is wrong.
inline std::vector<uint8_t> bytes_of(const Frame& frame) {
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i + 1 < frame.nibbles.size(); i += 2) {
    bytes.push_back(frame.nibbles[i] | frame.nibbles[i + 1] << 4);
  }
  if (bytes.size() < 64 || frame.nibbles.size() % 2) return {};
  uint32_t check = 0;
  for (int i = 0; i < 4; ++i) check |= uint32_t(bytes[bytes.size() - 4 + i]) << 8 * i;
  bytes.resize(bytes.size() - 4);
  return check == check_sequence(bytes.data(), bytes.size()) ? bytes : std::vector<uint8_t>{};
}

// Collects the frames of a stream of nibbles.
class Receiver {
 public:
  std::deque<Frame> frames;

  void take(const Nibble& nibble, uint64_t time) {
    if (nibble.valid) {
      if (!active_) {
        now_ = Frame{time, 0, {}, 0};
        active_ = true;
        body_ = false;
      }
      if (body_) {
        now_.nibbles.push_back(nibble.data);
      } else {
        ++now_.preamble;
        body_ = nibble.data == 0xD;
      }
    } else if (active_) {
      active_ = false;
      now_.ended = time;
      frames.push_back(now_);
    }
  }

 private:
  bool active_ = false, body_ = false;
  Frame now_;
};

// A master's transmitter: nibbles to come, with gaps.
class Sender {
 public:
  void send(const std::vector<uint8_t>& nibbles, int error_at, unsigned gap) {
    for (unsigned i = 0; i < gap; ++i) queue_.push_back({false, false, 0});
    for (unsigned i = 0; i < PREAMBLE_NIBBLES; ++i) queue_.push_back({true, false, 5});
    queue_.push_back({true, false, 0xD});
    for (size_t i = 0; i < nibbles.size(); ++i) queue_.push_back({true, int(i) == error_at, nibbles[i]});
  }

  Nibble next() {
    if (queue_.empty()) return {false, false, 0};
    Nibble nibble = queue_.front();
    queue_.pop_front();
    return nibble;
  }

 private:
  std::deque<Nibble> queue_;
};

template <typename Model>
class Ring {
 public:
  static constexpr int MASTER = -1;

  struct Slave : Bench<Slave, Model> {
    uint64_t period, next;
    size_t index;
    uint64_t arrived = 0;               // the last frame's first nibble at port 0
    unsigned phase;                     // of the transmitters
    std::deque<WireEvent> wire[2];      // what comes to its ports
    bool linked[2] = {false, false};
    std::function<void(Slave&)> application;  // before each rising edge
  };

  std::vector<std::unique_ptr<Slave>> slaves;
  Sender send[2];      // the master's ports: 0 at the first slave, 1 at the last one
  Receiver received[2];
  uint64_t now = 0;

  // ppm: of each slave's clock; cable_ps: from one to the next. closed: the master's second port has a cable.
  Ring(const std::vector<double>& ppm, uint64_t cable_ps, bool closed) : lengths_(ppm.size() + 1, cable_ps) {
    for (size_t i = 0; i < ppm.size(); ++i) {
      auto slave = std::make_unique<Slave>();
      slave->period = uint64_t(CLOCK_PS * (1 - ppm[i] * 1e-6) + 0.5);
      slave->phase = slave->index = i;
      auto* top = slave->top.get();
      top->link_i = 0;
      top->mii_rx_clk_i = top->mii_rx_dv_i = top->mii_rx_er_i = top->mii_rxd_i = 0;
      top->mii_tick_i = 0;
      slave->reset();
      slave->next = 1300 * i + slave->period;
      slaves.push_back(std::move(slave));
    }
    cables_.assign(ppm.size() + 1, true);
    cables_.back() = closed;
    link();
  }

  // Cable i is that before slave i; the last goes back to the master's second port.
  void cable(unsigned i, bool plugged) {
    cables_.at(i) = plugged;
    link();
  }

  // Delay of such a cable; nothing may be on its way.
  void length(unsigned i, uint64_t ps) { lengths_.at(i) = ps; }

  void run(uint64_t ps) {
    const uint64_t end = now + ps;
    while (true) {
      Slave* first = nullptr;
      size_t index = 0;
      uint64_t time = master_;
      for (size_t i = 0; i < slaves.size(); ++i) {
        if (slaves[i]->next < time) {
          time = slaves[i]->next;
          first = slaves[i].get();
          index = i;
        }
      }
      if (time > end) break;
      now = time;
      if (first) step(*first, index);
      else transmit();
    }
    now = end;
  }

 private:
  void link() {
    for (size_t i = 0; i < slaves.size(); ++i) {
      slaves[i]->linked[0] = cables_[i];
      slaves[i]->linked[1] = cables_[i + 1];
    }
  }

  // The master's ports put out a nibble each; what comes in there is taken with the wire's clock.
  void transmit() {
    for (int p = 0; p < 2; ++p) {
      const Nibble nibble = send[p].next();
      Slave& to = p ? *slaves.back() : *slaves.front();
      put(to, p, nibble);
    }
    master_ += NIBBLE_PS;
  }

  void put(Slave& to, int port, const Nibble& nibble) {
    if (!to.linked[port]) return;
    // While nothing comes the wire's clock need not be heard, except for the end of a frame.
    auto& wire = to.wire[port];
    if (!nibble.valid && silent_[{&to, port}]) return;
    const uint64_t time = now + lengths_[to.index + port];
    bool& silent = silent_[{&to, port}];
    if (silent && port == 0) to.arrived = time;
    silent = !nibble.valid;
    wire.push_back({time, false, nibble});
    wire.push_back({time + NIBBLE_PS / 2, true, nibble});
  }

  void step(Slave& slave, size_t index) {
    auto* top = slave.top.get();
    top->clk_i = 0;
    for (int p = 0; p < 2; ++p) {
      auto& wire = slave.wire[p];
      const unsigned bit = 1u << p;
      while (!wire.empty() && wire.front().time <= now) {
        const WireEvent& event = wire.front();
        top->mii_rx_clk_i = event.rise ? top->mii_rx_clk_i | bit : top->mii_rx_clk_i & ~bit;
        top->mii_rx_dv_i = event.nibble.valid ? top->mii_rx_dv_i | bit : top->mii_rx_dv_i & ~bit;
        top->mii_rx_er_i = event.nibble.error ? top->mii_rx_er_i | bit : top->mii_rx_er_i & ~bit;
        top->mii_rxd_i = (top->mii_rxd_i & ~(0xF << 4 * p)) | event.nibble.data << 4 * p;
        wire.pop_front();
      }
      top->link_i = slave.linked[p] ? top->link_i | bit : top->link_i & ~bit;
    }
    slave.phase = (slave.phase + 1) % CLOCKS_PER_NIBBLE;
    top->mii_tick_i = slave.phase == 0;
    top->eval();
    if (slave.application) slave.application(slave);
    slave.rise();
    slave.next += slave.period;
    if (slave.phase == 0) {
      for (int p = 0; p < 2; ++p) {
        const Nibble nibble{bool(top->mii_tx_en_o >> p & 1), false, uint8_t(top->mii_txd_o >> 4 * p & 0xF)};
        const size_t neighbour = index + (p ? 1 : -1);
        if (!slave.linked[p]) continue;
        if (p == 0 && index == 0) received[0].take(nibble, now);
        else if (p == 1 && index + 1 == slaves.size()) received[1].take(nibble, now);
        else put(*slaves[neighbour], 1 - p, nibble);
      }
    }
  }

  uint64_t master_ = 0;
  std::vector<uint64_t> lengths_;
  std::vector<bool> cables_;
  std::map<std::pair<Slave*, int>, bool> silent_;
};
