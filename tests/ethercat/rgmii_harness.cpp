// SPDX-License-Identifier: Apache-2.0
// One slave controller with two RGMII PHYs, with the C interface of slave_harness.cpp as far as it goes.
//
// The PHYs are written from RGMII 2.0 (signals, timing with internal delay, in-band status) and know nothing of the RTL.
// Data are arbitrary within 0.5 ns of a change, the clock within 0.1 ns of an edge. Times are in ps.
#include <algorithm>

#include "Vrgmii_slave.h"
#include "ring.h"

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int64_t SKEW_PS = 500, JITTER_PS = 100;

// How a PHY sends. period, high: of RXC; delay: of RXC after the data.
struct Shape {
  int64_t phase, period, high, delay;
  int repeat;  // the nibble is there at the falling edge too
};

struct Pins {
  bool clock, control;
  uint8_t data;
};

class Source {
 public:
  Sender sender;
  uint8_t status = 0;
  bool stopped = false;
  std::vector<uint64_t> began;  // rising edge of RXC in the first nibble of each frame

  void shape(const Shape& shape, uint64_t now) {
    shape_ = shape;
    from_ = now + shape.phase;
    index_ = -1;
  }

  Pins at(uint64_t now, Random& random) {
    const int64_t time = int64_t(now) - from_;
    while (index_ < floored(time, shape_.period)) next();
    const int64_t in_data = time - floored(time, shape_.period) * shape_.period;
    const int64_t clock = time - shape_.delay;
    const int64_t in_clock = clock - floored(clock, shape_.period) * shape_.period;
    Pins pins = in_data < shape_.high ? rising_ : falling_;
    const uint32_t noise = random.draw();
    if (near(in_data, SKEW_PS)) {
      pins.control = noise & 1;
      pins.data = noise >> 1 & 0xF;
    }
    pins.clock = in_clock < shape_.high;
    if (near(in_clock, JITTER_PS)) pins.clock = noise >> 5 & 1;
    if (stopped) pins.clock = false;
    return pins;
  }

 private:
  static int64_t floored(int64_t a, int64_t b) { return a / b - (a % b < 0); }

  bool near(int64_t in, int64_t width) const {
    return in < width || in > shape_.period - width || std::abs(in - shape_.high) < width;
  }

  // Between frames RXD is the status, with RX_DV and RX_ER both low.
  void next() {
    ++index_;
    const Nibble nibble = sender.next();
    if (nibble.valid && !rising_.control) began.push_back(from_ + index_ * shape_.period + shape_.delay);
    const bool frame = nibble.valid || nibble.error;
    rising_ = {false, nibble.valid, frame ? nibble.data : status};
    falling_ = {false, nibble.valid != nibble.error, rising_.data};
    if (!shape_.repeat && frame) falling_.data ^= 0xF;
  }

  Shape shape_{0, 40000, 20000, 2000, 1};
  int64_t from_ = 0, index_ = -1;
  Pins rising_{}, falling_{};
};

// What the PHY takes, with both edges of TXC, and the margins it had.
class Sink {
 public:
  Receiver receiver;
  uint64_t setup = ~0ull, hold = ~0ull, shortest = ~0ull, longest = 0;
  unsigned errors = 0, unlike = 0;  // nibbles with TX_ER, and with other data at the falling edge

  void see(const Pins& pins, uint64_t now) {
    if (pins.control != was_.control || pins.data != was_.data) {
      if (edge_) hold = std::min(hold, now - edge_);
      changed_ = now;
    }
    if (pins.clock != was_.clock) {
      if (changed_) setup = std::min(setup, now - changed_);
      edge_ = now;
      if (pins.clock) {
        if (rise_) {
          shortest = std::min(shortest, now - rise_);
          longest = std::max(longest, now - rise_);
        }
        rise_ = now;
        taken_ = pins;
      } else {
        const bool error = taken_.control != pins.control;
        errors += error;
        unlike += taken_.data != pins.data;
        receiver.take({taken_.control, error, taken_.data}, rise_);
      }
    }
    was_ = pins;
  }

 private:
  Pins was_{}, taken_{};
  uint64_t changed_ = 0, edge_ = 0, rise_ = 0;
};

// Clocks from the edge that sees one signal rise to that which sees the other do so for it. The first high part of
// RXC after reset may be cut short.
class Distance {
 public:
  static constexpr uint64_t SETTLED = 100;
  unsigned least = ~0u, most = 0;

  explicit Distance(bool first = false) : was_first_(first) {}

  void see(bool first, bool second, uint64_t clock) {
    if (first && !was_first_) open_.push_back(clock);
    if (second && !was_second_ && !open_.empty()) {
      if (clock > SETTLED) {
        least = std::min<unsigned>(least, clock - open_.front());
        most = std::max<unsigned>(most, clock - open_.front());
      }
      open_.pop_front();
    }
    was_first_ = first;
    was_second_ = second;
  }

 private:
  std::deque<uint64_t> open_;
  bool was_first_, was_second_ = false;
};

struct Bus : Bench<Bus, Vrgmii_slave> {
  Source source[2];
  Sink sink[2];
  Distance receive{true}, to_rise, send;  // RXC is low before
  Random random{1};
  uint64_t now = 0, period;

  explicit Bus(double ppm) : period(uint64_t(CLOCK_PS * (1 - ppm * 1e-6) + 0.5)) {
    top->rgmii_rxc_i = top->rgmii_rx_ctl_i = top->rgmii_rxd_i = top->mii_tick_i = 0;
    reset();
  }

  void run(uint64_t ps) {
    const uint64_t end = now + ps;
    for (; now + period <= end; now += period) step();
  }

 private:
  void step() {
    top->clk_i = 0;
    uint8_t clock = 0, control = 0, data = 0;
    for (int p = 0; p < 2; ++p) {
      const Pins pins = source[p].at(now, random);
      clock |= pins.clock << p;
      control |= pins.control << p;
      data |= pins.data << 4 * p;
    }
    top->rgmii_rxc_i = clock;
    top->rgmii_rx_ctl_i = control;
    top->rgmii_rxd_i = data;
    top->mii_tick_i = clocks % CLOCKS_PER_NIBBLE == 0;
    top->eval();
    // Of port 0, as the coming edge sees them.
    receive.see(!(clock & 1), top->mii_rx_clk_o & 1, clocks);
    to_rise.see(clock & 1, top->mii_rx_clk_o & 1, clocks);
    send.see(top->mii_tx_en_o & 1, top->rgmii_tx_ctl_o & 1, clocks);
    rise();
    for (int p = 0; p < 2; ++p) {
      sink[p].see({bool(top->rgmii_txc_o >> p & 1), bool(top->rgmii_tx_ctl_o >> p & 1),
                   uint8_t(top->rgmii_txd_o >> 4 * p & 0xF)},
                  now);
    }
  }
};

}  // namespace

EXPORT Bus* bus_new(double ppm) { return new Bus(ppm); }
EXPORT void bus_delete(Bus* bus) { delete bus; }
EXPORT void bus_run(Bus* bus, uint64_t ns) { bus->run(ns * 1000); }
EXPORT uint64_t bus_now(Bus* bus) { return bus->now; }

EXPORT void bus_shape(Bus* bus, int port, int64_t phase, int64_t period, int64_t high, int64_t delay, int repeat) {
  bus->source[port].shape({phase, period, high, delay, repeat}, bus->now);
}
EXPORT void bus_status(Bus* bus, int port, unsigned status) { bus->source[port].status = status; }
EXPORT void bus_stopped(Bus* bus, int port, int stopped) { bus->source[port].stopped = stopped; }
EXPORT int bus_link(Bus* bus, int port) { return bus->top->link_o >> port & 1; }

EXPORT void bus_send(Bus* bus, int port, const uint8_t* nibbles, unsigned n, int error_at, unsigned gap) {
  bus->source[port].sender.send(std::vector<uint8_t>(nibbles, nibbles + n), error_at, gap);
}

EXPORT int bus_receive(Bus* bus, int port, uint8_t* nibbles, unsigned most, uint64_t* times) {
  auto& frames = bus->sink[port].receiver.frames;
  if (frames.empty()) return -1;
  const Frame frame = frames.front();
  frames.pop_front();
  std::copy_n(frame.nibbles.begin(), std::min<size_t>(frame.nibbles.size(), most), nibbles);
  times[0] = frame.began;
  times[1] = frame.ended;
  return frame.nibbles.size();
}

// When frame n from this port began at its pins, by the rising RXC.
EXPORT uint64_t bus_began(Bus* bus, int port, unsigned n) { return bus->source[port].began.at(n); }

// Of a port's transmitter: least setup and hold, shortest and longest period, nibbles with TX_ER, with unlike halves.
EXPORT void bus_margins(Bus* bus, int port, uint64_t* found) {
  const Sink& sink = bus->sink[port];
  const uint64_t all[] = {sink.setup, sink.hold, sink.shortest, sink.longest, sink.errors, sink.unlike};
  std::copy(std::begin(all), std::end(all), found);
}

// Least and most clocks: falling RXC to MII's rising clock, rising RXC to it, TX_EN to TX_CTL.
EXPORT void bus_latencies(Bus* bus, unsigned* found) {
  const unsigned all[] = {bus->receive.least, bus->receive.most, bus->to_rise.least,
                          bus->to_rise.most,  bus->send.least,   bus->send.most};
  std::copy(std::begin(all), std::end(all), found);
}
