// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated drive_chain with its motors around it (chain.py): encoder edges and modulator
// bits into it, gate edges out of it. Gates act on the switches after their delays, at fractions of a
// clock; between two switching edges the windings are exact. Each modulator bit, 6 clocks, currents
// and encoder lines are renewed; the mechanics take a step every 21 bits.
#include <algorithm>
#include <deque>
#include <vector>

#include "Vdrive_chain.h"
#include "dual_bench.h"
#include "plant.h"

namespace {

using servo::Axis;
using servo::kAxes;
constexpr double kClock = SERVO_CLOCK;  // s; from clocks.py, as the clocks of a half
constexpr uint32_t kHalf = SERVO_HALF, kFirstHalf = 64, kBits = 21;
constexpr uint32_t kOrders = 100, kWindow = 751;  // clocks of a half: host's orders; a mean begins
constexpr double kBusScale = 0.05;
constexpr uint32_t kIndex = 4096;  // counts between two indices

// Means of a half period, around the instant of a sample.
struct Half {
  double i_d[kAxes], i_q[kAxes], position[kAxes], duty[3 * kAxes];
};

struct Edge {
  double clock;
  uint32_t phase;
  bool on;
};

struct System : DualBench<System, Vdrive_chain> {
  servo::Parameters p{};
  servo::Mechanics mechanics;
  servo::Windings windings[kAxes];
  double behind[kAxes] = {};        // clock up to which a winding is solved
  bool high[15] = {}, low[15] = {}; // switches that conduct
  uint32_t gates = 0;               // low 15: high gates; next 15: low gates
  uint32_t shoot_through = 0;       // edges after which both gates or both switches of a phase are on
  std::deque<Edge> on, off;         // of gates (phase 0..14: high, 15..29: low), on their way to switches
  double first[kAxes][3] = {}, second[kAxes][3] = {};  // integrators of the modulators
  int64_t start[kAxes] = {};        // counts at reset
  servo::Five force{};              // sum over the bits of a step
  double cosine[kAxes], sine[kAxes];  // of the electrical angle, at the last step
  uint64_t stepped = 0;
  uint32_t bits = 0;
  uint64_t born = 0;                // clock of the reset's end
  bool mclk = false, tracing = false, ready = false;
  Half mean{};
  uint32_t mean_bits = 0;
  std::vector<Half> halves;
  std::deque<Write> orders;         // rows of kAxes, a row a half period
  servo::Five joints{}, tool{};     // at the last control period's begin
  uint64_t begun = 0;
  servo::Five spin{};               // speeds of a test bench that holds them, with `spun`
  bool spun = false, travels = false;
  std::deque<servo::Five> travel;   // joints that it moves to, a row a half period
  // faults
  uint32_t lost = 0, touching = 0, shorted = 0;  // bit n: axis n
  uint32_t stuck = 0, broken = 0;   // bit kAxes * k + n: sensor or phase k of axis n
  uint32_t slips = 0;               // bit n: axis n loses a count in every `slip`, from slip_start on
  int64_t slip = 1, slip_start[kAxes] = {};
  double drift[kAxes][3] = {};      // what sensors show too much [A]
  double volts = 0;
  uint64_t tripped = 0;             // clock in which all gates of an axis that ran were off, 0: none

  System() {
    top->a_i = top->b_i = top->z_i = 0;
    top->bit_a_i = top->bit_b_i = top->bit_c_i = 0;
    top->bus_i = 0;
    top->fault_i = 0;
    begin();
    born = clocks - 1;
  }

  void place(const servo::Parameters& parameters, const double* at) {
    p = parameters;
    servo::Five q;
    std::copy(at, at + kAxes, q.begin());
    mechanics.place(p, q);
    volts = p.U_dc;
    stepped = clocks;
    for (int n = 0; n < kAxes; ++n) {
      start[n] = count(n, clocks);
      behind[n] = clocks;
    }
    angles();
    encoders();
    top->bus_i = std::lround(volts / kBusScale);
    ready = true;
  }

  int64_t count(int n, double clock) const {
    const double x = mechanics.position[n] + mechanics.speed[n] * (clock - stepped) * kClock;
    return std::llround(std::floor(x / p.axis[n].resolution + 0.5));
  }

  void angles() {
    for (int n = 0; n < kAxes; ++n) {
      const double angle = p.axis[n].wave * mechanics.position[n] + p.axis[n].angle_offset;
      cosine[n] = std::cos(angle);
      sine[n] = std::sin(angle);
    }
  }

  // Counts and exact state in the first clock of a control period.
  void measure(Period* period, bool) {
    if (!top->period_o) return;
    const double since = (clocks - stepped) * kClock;
    for (int n = 0; n < kAxes; ++n) {
      period->measured[n] = top->measured_o[n];
      joints[n] = mechanics.position[n] + mechanics.speed[n] * since;
      tool[n] = mechanics.q[n] + mechanics.v[n] * since;
    }
    begun = clocks;
  }

  void edge() {
    DualBench::edge();
    if (!ready) return;
    const uint32_t now = top->high_o | uint32_t(top->low_o) << 15;
    if (now != gates) switch_gates(now);
    const bool was = mclk;
    mclk = top->mclk_o;
    if (mclk && !was) bit();
    const uint32_t place = (clocks - born - kFirstHalf) % kHalf;
    if (place == kWindow && tracing && mean_bits) keep();
    if (place == kWindow && travels) {
      spin = {};
      for (int n = 0; n < kAxes && !travel.empty(); ++n)
        spin[n] = (travel.front()[n] - mechanics.position[n]) / (kHalf * kClock);
      if (!travel.empty()) travel.pop_front();
    }
    if (place == kOrders)
      for (int n = 0; n < kAxes && !orders.empty(); ++n) {
        queue.push_back(orders.front());
        orders.pop_front();
      }
  }

  void switch_gates(uint32_t now) {
    shoot_through += (now & now >> 15 & 0x7fff) != 0;
    for (uint32_t bit = 0; bit < 30; ++bit) {
      if (!((now ^ gates) >> bit & 1)) continue;
      const bool rises = now >> bit & 1;
      const double delay = (rises ? p.delay_on : p.delay_off) / kClock;
      (rises ? on : off).push_back({clocks + delay, bit, rises});
    }
    if (gates && !now) tripped = clocks;
    gates = now;
  }

  // Solves the windings of an axis up to a clock, with the switches as they are.
  void solve(int n, double clock) {
    const double time = (clock - behind[n]) * kClock;
    if (time <= 0) return;
    Axis axis = p.axis[n];
    if (shorted >> n & 1) axis.L_d *= 0.02, axis.L_q *= 0.02, axis.R *= 0.02;
    const double w = axis.wave * mechanics.speed[n];
    double c, s;
    turned(n, behind[n], c, s);
    const auto current = windings[n].phases(c, s);
    double u[3], alpha, beta;
    for (int k = 0; k < 3; ++k)
      u[k] = servo::terminal(p, high[3 * n + k], low[3 * n + k], volts, current[k], axis.L_q, time);
    servo::space_vector(u, alpha, beta);
    windings[n].advance(axis, alpha, beta, c, s, w, time);
    for (int k = 0; k < 3; ++k) {
      if (!(broken >> (kAxes * k + n) & 1)) continue;
      turned(n, clock, c, s);
      windings[n].open(axis, k, c, s);
    }
    behind[n] = clock;
  }

  void turned(int n, double clock, double& c, double& s) const {
    const double a = p.axis[n].wave * mechanics.speed[n] * (clock - stepped) * kClock;
    const double c1 = 1 - a * a / 2, s1 = a - a * a * a / 6;
    c = cosine[n] * c1 - sine[n] * s1;
    s = sine[n] * c1 + cosine[n] * s1;
  }

  void bit() {
    const double now = clocks;
    for (;;) {
      const bool later = on.empty() || (!off.empty() && off.front().clock <= on.front().clock);
      auto& queue = later ? off : on;
      if (queue.empty() || queue.front().clock > now) break;
      const Edge edge = queue.front();
      queue.pop_front();
      const uint32_t phase = edge.phase % 15;
      solve(phase / 3, edge.clock);
      (edge.phase < 15 ? high : low)[phase] = edge.on;
      shoot_through += high[phase] && low[phase];
    }
    uint32_t sensed[3] = {};
    for (int n = 0; n < kAxes; ++n) {
      solve(n, now);
      double c, s;
      turned(n, now, c, s);
      const Axis& axis = p.axis[n];
      const auto current = windings[n].phases(c, s);
      // The third sensor has the errors of the second with the other sign.
      const double gain[3] = {axis.gain_a, axis.gain_b, -axis.gain_b};
      const double offset[3] = {axis.offset_a, axis.offset_b, -axis.offset_b};
      for (int k = 0; k < 3; ++k) {
        const bool dead = stuck >> (kAxes * k + n) & 1;
        const double shown = dead ? 0 : current[k] * (1 + gain[k]) + offset[k] + drift[n][k];
        sensed[k] |= modulate(n, k, shown / p.current_scale) << n;
      }
      force[n] += windings[n].force(axis);
      mean.i_d[n] += windings[n].i_d;
      mean.i_q[n] += windings[n].i_q;
      for (int k = 0; k < 3; ++k) mean.duty[3 * n + k] += high[3 * n + k];
    }
    ++mean_bits;
    top->bit_a_i = sensed[0];
    top->bit_b_i = sensed[1];
    top->bit_c_i = sensed[2];
    if (++bits == kBits) {
      bits = 0;
      for (double& f : force) f /= kBits;
      const double time = (clocks - stepped) * kClock;
      if (spun) mechanics.spin(spin, time);
      else mechanics.advance(p, force, top->release_o, time);
      force = {};
      stepped = clocks;
      angles();
    }
    encoders();
  }

  // Second order, its bits as those of tests/servo/test_currents.py.
  uint32_t modulate(int n, int k, double x) {
    const uint32_t one = second[n][k] >= 0;
    const double back = one ? 1 : -1;
    first[n][k] += x - back;
    second[n][k] += first[n][k] - 2 * back;
    first[n][k] = std::clamp(first[n][k], -8.0, 8.0);  // an overload saturates
    second[n][k] = std::clamp(second[n][k], -16.0, 16.0);
    return one;
  }

  void encoders() {
    uint32_t a = 0, b = 0, z = 0;
    for (int n = 0; n < kAxes; ++n) {
      const int64_t at = count(n, clocks);
      const int64_t shown = (slips >> n & 1) ? at - (at - slip_start[n]) / slip : at;
      const uint32_t quarter = (lost >> n & 1) ? 0 : shown & 3;
      a |= uint32_t(quarter == 1 || quarter == 2) << n;
      b |= uint32_t(quarter == 2 || quarter == 3) << n;
      z |= uint32_t((at & (kIndex - 1)) == 2) << n;
    }
    const uint32_t noise = (clocks >> 10 & 1) ? touching : 0;  // on both lines at once
    top->a_i = (a & ~touching) | noise;
    top->b_i = (b & ~touching) | noise;
    top->z_i = z;
  }

  void keep() {
    for (int n = 0; n < kAxes; ++n) {
      mean.i_d[n] /= mean_bits;
      mean.i_q[n] /= mean_bits;
      mean.position[n] = mechanics.position[n];
      for (int k = 0; k < 3; ++k) mean.duty[3 * n + k] /= mean_bits;
    }
    halves.push_back(mean);
    mean = {};
    mean_bits = 0;
  }
};

}  // namespace

#include "dual_api.h"

extern "C" {

// Puts the plant at rest at (x, y, z, tilt, rotation); counts of the encoders there.
void chain_place(void* handle, const servo::Parameters* p, const double* at, int64_t* counts) {
  auto* chain = static_cast<System*>(handle);
  chain->place(*p, at);
  std::copy(chain->start, chain->start + kAxes, counts);
}

// joints, tool and table (x, y, z, tilt, rotation), i_d, i_q, bristles, speeds of tool and table: five each; then
// clocks since the reset's end, edges with shoot-through, open brakes, clock of the last moment without gates,
// whether the chopper is on.
void chain_look(void* handle, double* out) {
  auto* chain = static_cast<System*>(handle);
  for (int n = 0; n < kAxes; ++n) {
    out[n] = chain->mechanics.position[n];
    out[5 + n] = chain->mechanics.q[n];
    out[10 + n] = chain->windings[n].i_d;
    out[15 + n] = chain->windings[n].i_q;
    out[20 + n] = chain->mechanics.z[n];
    out[25 + n] = chain->mechanics.v[n];
  }
  out[30] = double(chain->clocks - chain->born);
  out[31] = chain->shoot_through;
  out[32] = chain->top->release_o;
  out[33] = double(chain->tripped - chain->born);
  out[34] = chain->top->chopper_o;
}

// Joints and (x, y, z, tilt, rotation) at the last control period's begin, and its clock in a half.
void chain_begun(void* handle, double* out) {
  auto* chain = static_cast<System*>(handle);
  for (int n = 0; n < kAxes; ++n) out[n] = chain->joints[n], out[5 + n] = chain->tool[n];
  out[10] = double((chain->begun - chain->born - kFirstHalf) % kHalf);
}

// Begins (and empties) or ends the record of half periods.
void chain_trace(void* handle, int on) {
  auto* chain = static_cast<System*>(handle);
  chain->tracing = on != 0;
  chain->halves.clear();
  chain->mean = {};
  chain->mean_bits = 0;
}

// Copies at most n half periods; returns how many there are.
uint32_t chain_halves(void* handle, double* out, uint32_t n) {
  const auto& halves = static_cast<System*>(handle)->halves;
  n = std::min<uint32_t>(n, halves.size());
  std::memcpy(out, halves.data(), n * sizeof(Half));
  return halves.size();
}

// Orders that the host writes, a row of five a half period, at these addresses.
void chain_orders(void* handle, const uint32_t* address, const uint32_t* rows, uint32_t n) {
  auto& orders = static_cast<System*>(handle)->orders;
  for (uint32_t i = 0; i < n * kAxes; ++i) orders.push_back({address[i % kAxes], rows[i]});
}

// Lets a test bench turn the axes at these speeds [m/s, rad/s], whatever the forces.
void chain_spin(void* handle, const double* speeds) {
  auto* chain = static_cast<System*>(handle);
  std::copy(speeds, speeds + kAxes, chain->spin.begin());
  chain->spun = true;
}

// Lets the test bench move the joints to a row of five in each of the next half periods, from one record to the next;
// there they stay.
void chain_travel(void* handle, const double* rows, uint32_t n) {
  auto* chain = static_cast<System*>(handle);
  for (uint32_t i = 0; i < n; ++i, rows += kAxes) {
    chain->travel.emplace_back();
    std::copy(rows, rows + kAxes, chain->travel.back().begin());
  }
  chain->spun = chain->travels = true;
}

// State of the first integrators of the modulators, two an axis: other values are another draw of their noise.
void chain_modulators(void* handle, const double* state) {
  auto* chain = static_cast<System*>(handle);
  for (int n = 0; n < kAxes; ++n)
    for (int k = 0; k < 2; ++k) chain->first[n][k] = *state++;
}

// Faults: axes (a bit each) whose encoder rests low, whose encoder lines touch, whose windings are
// shorted, whose power stage reports a fault; the bus voltage.
void chain_fault(void* handle, uint32_t lost, uint32_t touching, uint32_t shorted, uint32_t stage, double volts) {
  auto* chain = static_cast<System*>(handle);
  chain->lost = lost;
  chain->touching = touching;
  chain->shorted = shorted;
  chain->top->fault_i = stage;
  chain->volts = volts;
  chain->top->bus_i = std::lround(volts / kBusScale);
}

// Encoders (a bit each) that lose one of `every` counts from now on; the index stays where it is.
void chain_slip(void* handle, uint32_t axes, int64_t every) {
  auto* chain = static_cast<System*>(handle);
  chain->slips = axes;
  chain->slip = every;
  for (int n = 0; n < kAxes; ++n) chain->slip_start[n] = chain->count(n, chain->clocks);
}

// Sensors that show no current and phases that are open, bit kAxes * k + n of phase k of axis n; what sensors show
// too much [A], three an axis.
void chain_sensors(void* handle, uint32_t stuck, const double* drift, uint32_t broken) {
  auto* chain = static_cast<System*>(handle);
  chain->stuck = stuck;
  chain->broken = broken;
  for (int n = 0; n < kAxes; ++n)
    for (int k = 0; k < 3; ++k) chain->drift[n][k] = *drift++;
}

}  // extern "C"
