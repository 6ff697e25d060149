// SPDX-License-Identifier: Apache-2.0
// The plant with inverters averaged over a half period of the carrier, and the current loops' program as C,
// for whole paths. C interface for averaged.py; the same windings and mechanics as chain_harness.cpp.
// In each half: the phases' mean voltages, from switch to switch; the currents as they are in the middle
// of their window; the program at the window's end; its values in the next half.
#include <cmath>
#include <cstring>

#include "current_loops.tick.h"
#include "plant.h"

namespace {

using servo::Axis;
using servo::kAxes;
constexpr int kHalf = SERVO_HALF;  // clocks; from clocks.py, as the clock's period
constexpr double kNever = INFINITY, kStep = 12;  // clocks; of a current that may end
constexpr double kClock = SERVO_CLOCK, kMagic = 12582912, kBusScale = 0.05, kFull = 131072;
static_assert(sizeof(current_loops_inputs) == 26 * sizeof(float), "words of the link and orders");
static_assert(sizeof(current_loops_outputs) == 15 * sizeof(float), "compare values");

// A phase of an inverter. Clocks of this half period at which its switches change, after its end: none.
struct Phase {
  bool ordered = false, high = false, low = true;
  double off = kNever, on = kNever;
};

struct Averaged {
  servo::Parameters p;
  servo::Mechanics mechanics;
  servo::Windings windings[kAxes];
  current_loops_states states = current_loops_initial;
  double compare[kAxes][3] = {};  // in force
  Phase phases[kAxes][3];
  std::array<double, 3> means[kAxes] = {};  // of the phases' voltages, this half
  int64_t start[kAxes];
  uint32_t released = (1 << kAxes) - 1;
  double middle, end, least;      // clocks of a half: middle of the window, samples; PWM.minimum
  double noise;                   // of a sample [A], standard deviation
  uint64_t seed = 88172645463325252ull;
  bool up = true, turned = false;  // turned: by a test bench, at its speeds
  bool faulted = false;

  int64_t count(int n) const {
    return std::llround(std::floor(mechanics.position[n] / p.axis[n].resolution + 0.5));
  }

  double gauss() {  // sum of twelve uniform numbers
    double sum = -6;
    for (int n = 0; n < 12; ++n) {
      seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
      sum += double(seed >> 11) * 0x1p-53;
    }
    return sum;
  }

  double angle(int n) const { return p.axis[n].wave * mechanics.position[n] + p.axis[n].angle_offset; }

  // Means of an axis' phases over this half period against the bus's middle, from switch to switch: the currents
  // keep a diode on through the dead time, or end in it.
  void voltages(int n) {
    const Axis& axis = p.axis[n];
    const double w = axis.wave * mechanics.speed[n] * kClock;
    double c = std::cos(angle(n)), s = std::sin(angle(n)), edge[3];
    servo::Windings trial = windings[n];
    auto& mean = means[n];
    mean = {};
    for (int k = 0; k < 3; ++k) {
      const double high = compare[n][k];
      edge[k] = up ? high : kHalf - high;
      if (phases[n][k].ordered != (up ? high > 0 : high >= kHalf)) order(phases[n][k], 0);
    }
    for (double now = 0; now < kHalf;) {
      const auto current = trial.phases(c, s);
      double next = kHalf, u[3], alpha, beta;
      for (int k = 0; k < 3; ++k) {
        Phase& phase = phases[n][k];
        if (edge[k] <= now && phase.ordered == up) order(phase, edge[k]);
        if (phase.off <= now) phase.high = phase.low = false, phase.off = kNever;
        if (phase.on <= now) (phase.ordered ? phase.high : phase.low) = true, phase.on = kNever;
        for (const double at : {edge[k], phase.off, phase.on})
          if (at > now) next = std::min(next, at);
      }
      for (int k = 0; k < 3; ++k)
        if (ending(axis, phases[n][k], current[k], next - now)) next = std::min(next, now + kStep);
      const double time = (next - now) * kClock;
      for (int k = 0; k < 3; ++k) {
        u[k] = servo::terminal(p, phases[n][k].high, phases[n][k].low, p.U_dc, current[k], axis.L_q, time);
        mean[k] += u[k] * (next - now) / kHalf;
      }
      servo::space_vector(u, alpha, beta);
      trial.advance(axis, alpha, beta, c, s, w / kClock, time);
      const double turn = w * (next - now), before = c;
      c -= turn * s, s += turn * before;
      now = next;
    }
    for (Phase& phase : phases[n]) phase.off -= kHalf, phase.on -= kHalf;
  }

  // The other gate, from a clock on.
  void order(Phase& phase, double clock) const {
    phase.ordered = !phase.ordered;
    phase.off = clock + p.delay_off / kClock;
    phase.on = clock + (p.dead_time + p.delay_on) / kClock;
  }

  // Whether a diode's current may end within so many clocks.
  bool ending(const Axis& axis, const Phase& phase, double current, double clocks) const {
    return !phase.high && !phase.low && std::fabs(current) * axis.L_q < 2 * p.U_dc * clocks * kClock;
  }

  void advance(double clocks) {
    const double time = clocks * kClock;
    servo::Five force;
    for (int n = 0; n < kAxes; ++n) {
      const Axis& axis = p.axis[n];
      const double c = std::cos(angle(n)), s = std::sin(angle(n));
      double alpha, beta;
      servo::space_vector(means[n].data(), alpha, beta);
      const double before = windings[n].force(axis);
      windings[n].advance(axis, alpha, beta, c, s, axis.wave * mechanics.speed[n], time);
      force[n] = (before + windings[n].force(axis)) / 2;
    }
    if (turned) mechanics.spin(mechanics.speed, time);
    else mechanics.advance(p, force, released, time);
  }

  static float word(double value) { return float(kMagic + std::nearbyint(value)); }

  void half(const float* orders) {
    float in[26];
    for (int n = 0; n < kAxes; ++n) voltages(n);
    advance(middle);
    for (int n = 0; n < kAxes; ++n) {
      const Axis& axis = p.axis[n];
      const auto current = windings[n].phases(std::cos(angle(n)), std::sin(angle(n)));
      const double scale = kFull / p.current_scale;
      in[4 * n + 1] = word((current[0] * (1 + axis.gain_a) + axis.offset_a + noise * gauss()) * scale);
      in[4 * n + 2] = word((current[1] * (1 + axis.gain_b) + axis.offset_b + noise * gauss()) * scale);
      in[4 * n + 3] = kMagic;
    }
    advance(end - middle);
    for (int n = 0; n < kAxes; ++n) in[4 * n] = word(count(n) - start[n]);
    in[20] = word(p.U_dc / kBusScale);
    std::memcpy(in + 21, orders, kAxes * sizeof(float));
    current_loops_inputs inputs;
    current_loops_outputs outputs;
    std::memcpy(&inputs, in, sizeof in);
    faulted |= current_loops_tick(&inputs, &states, &outputs) != 0;
    advance(kHalf - end);
    float values[15];
    std::memcpy(values, &outputs, sizeof values);
    for (int n = 0; n < 15; ++n) {  // as pwm_bound has it
      const double value = values[n] - kMagic;
      compare[n / 3][n % 3] = value < least ? 0 : value > kHalf - least ? kHalf : value;
    }
    up = !up;
  }
};

}  // namespace

extern "C" {

// At rest at (x, y, z, tilt, rotation); middle, end, least: clocks of a half; noise [A].
void* averaged_new(const servo::Parameters* p, const double* at, double middle, double end, double least,
                   double noise, int64_t* counts) {
  auto* a = new Averaged;
  a->p = *p;
  servo::Five q;
  std::copy(at, at + kAxes, q.begin());
  a->mechanics.place(*p, q);
  a->middle = middle, a->end = end, a->least = least, a->noise = noise;
  for (int n = 0; n < kAxes; ++n) {
    counts[n] = a->start[n] = a->count(n);
    for (int k = 0; k < 3; ++k) a->compare[n][k] = kHalf / 2;
  }
  return a;
}

// Puts tool and table there (x, y, z, tilt, rotation), with these speeds and bristles; the counters go on from
// where they began.
void averaged_put(void* handle, const double* at, const double* rates, const double* bristles) {
  auto* a = static_cast<Averaged*>(handle);
  servo::Five q, v;
  std::copy(at, at + kAxes, q.begin());
  std::copy(rates, rates + kAxes, v.begin());
  a->mechanics.place(a->p, q, v);
  std::copy(bristles, bristles + kAxes, a->mechanics.z.begin());
}

void averaged_free(void* handle) { delete static_cast<Averaged*>(handle); }

void averaged_brakes(void* handle, uint32_t released) { static_cast<Averaged*>(handle)->released = released; }

// Half periods with a row of orders each; rows of 15: i_d, i_q, joint positions at the samples' instant's half end.
// joints: n + 1 rows of five, or none: where a test bench moves the joints from, whatever the forces.
int averaged_halves(void* handle, const float* orders, const double* joints, double* out, uint32_t n) {
  auto* a = static_cast<Averaged*>(handle);
  for (uint32_t i = 0; i < n; ++i, orders += kAxes) {
    a->turned = joints != nullptr;
    for (int axis = 0; joints && axis < kAxes; ++axis, ++joints) {
      a->mechanics.position[axis] = joints[0];
      a->mechanics.speed[axis] = (joints[kAxes] - joints[0]) / (kHalf * kClock);
    }
    a->half(orders);
    for (int axis = 0; out && axis < kAxes; ++axis) {
      out[axis] = a->windings[axis].i_d;
      out[5 + axis] = a->windings[axis].i_q;
      out[10 + axis] = a->mechanics.position[axis];
    }
    if (out) out += 15;
  }
  return a->faulted;
}

// joints, place: five each; counts at this instant.
void averaged_look(void* handle, double* out, int64_t* counts) {
  auto* a = static_cast<Averaged*>(handle);
  for (int n = 0; n < kAxes; ++n) {
    out[n] = a->mechanics.position[n];
    out[5 + n] = a->mechanics.q[n];
    out[10 + n] = a->mechanics.speed[n];
    out[15 + n] = a->windings[n].i_d;
    out[20 + n] = a->windings[n].i_q;
    counts[n] = a->count(n);
  }
}

// Rates (x, y, z, tilt, rotation) of the mechanics alone, for forces of the joints.
void averaged_rates(const servo::Parameters* p, const double* q, const double* v, const double* f, double* out) {
  servo::Five a, b, c;
  std::copy(q, q + kAxes, a.begin());
  std::copy(v, v + kAxes, b.begin());
  std::copy(f, f + kAxes, c.begin());
  const servo::Five rates = servo::Mechanics::rates(*p, a, b, c);
  std::copy(rates.begin(), rates.end(), out);
}

}  // extern "C"
