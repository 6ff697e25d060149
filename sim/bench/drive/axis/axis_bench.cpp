// SPDX-License-Identifier: Apache-2.0
// One motor with its inverter, current sensors and encoder, and the program that closes its loops as C: the
// bench of sim/bench/drive/axis/bench.py. Windings, terminals and friction are those of plant.h. Switches change
// at fractions of a clock, as in averaged.cpp; the windings are solved from one change to the next and at each
// modulator bit. The modulators are of second order, their bits weighted by sinc3 over the carrier's window, as
// chain_harness.cpp and rtl/drive/sinc3_filter.sv have them.
#include <cmath>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include "plant.h"

namespace {

using servo::Axis;
constexpr int kHalf = SERVO_HALF;  // clocks; from clocks.py, as the clock's period
constexpr double kNever = INFINITY, kStep = 12;  // clocks; of a current that may end
constexpr double kClock = SERVO_CLOCK, kMagic = 12582912, kBusScale = 0.05, kFull = 131072;
constexpr int kBit = 6, kRate = 64, kBits = 3 * kRate, kMechanics = 21;  // clocks; bits of a window; bits of a step
constexpr int kInputs = 24, kOutputs = 16, kStates = 64;                 // words of a program at most
using Tick = int (*)(const float*, float*, float*);

struct Phase {
  bool ordered = false, high = false, low = false;
  double off = kNever, on = kNever;
};

// The count of an encoder without lines A and B, as rtl/drive/absolute_position.sv has it, from event to event.
struct Frames {
  double period = 0, late = 0;                          // clocks; of a frame until it acts; 0: lines A and B
  double next = kNever, taken = 0, before = 0, at = 0;  // next instant, of the frame, of the last one used; of `anchor`
  double anchor = 0, rate = 0, seen = 0;                // counts, counts a clock, extrapolated count at the instant
  int64_t word = 0, used = 0;
  uint32_t lose = 0;
  bool pending = false, known = false;

  double count(double clock) const { return anchor + std::floor(rate * (clock - at) + 0.5); }

  void instant(double clock, int64_t position) {
    taken = clock, word = position, seen = count(clock), next = clock + period;
    pending = !lose;
    if (lose) --lose;
  }

  void act(double clock) {
    if (!pending || clock < taken + late) return;
    const double then = taken + late, moved = known ? double(word - used) : 0;
    anchor = count(then) + (known ? double(used) : double(word)) + moved - seen, at = then;
    if (known) rate = moved / (taken - before);
    used = word, before = taken, known = true, pending = false;
  }
};

// Sine and cosine lines, as rtl/drive/sincos_position.sv reads them: the position by the arctangent of both, its
// lines by the shorter way from the sample before.
struct SineLines {
  double size = 0;                         // counts of a line; 0: another encoder
  double offset = 0, gain = 0, noise = 0;  // of the sine, of its amplitude; rms of both samples
  int64_t count = 0;
  bool known = false;
  std::mt19937_64 random{1};
  std::normal_distribution<double> normal;

  int64_t read(double position) {
    const double angle = 2 * M_PI * position / size;
    const double sine = (1 + gain) * std::sin(angle) + offset + noise * normal(random);
    const double cosine = std::cos(angle) + noise * normal(random);
    const int64_t line = std::llround(size), word = std::llround(std::floor(std::atan2(sine, cosine) / (2 * M_PI) * size + 0.5));
    if (!known) count = std::llround(position), known = true;
    int64_t way = (word - count) % line;
    if (way < -line / 2) way += line;
    if (way >= line / 2) way -= line;
    return count += way;
  }
};

// Three Hall lines and the count of rtl/drive/hall_decoder.sv, from edge to edge of the lines.
struct Hall {
  double size = 0, filter = 0, limit = 0, error = 0;  // counts of a sector, 0: another encoder; clocks; v late, w early
  int wires[3] = {0, 1, 2};                           // of u, v, w: a sensor, 3 more: inverted; 6: low, 7: high
  double seen = 0, changed = kNever, edge = 0, span = 1, since = 0;  // clocks; edge: of the last sector, visible
  int state = -1, pending = -1, place = -1;
  int64_t sector = 0;
  bool timed = false, down = false, moves = false, wrong = false;
  uint32_t bad = 0;
  std::vector<double> log;  // clock and state of each change

  int lines(double position) const {
    const double turn = position / (6 * size), late[3] = {0, error, -error};
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      const int n = wires[k] % 3;
      const double at = turn - n / 3. - late[n] / (2 * M_PI);
      const bool high = wires[k] > 5 ? wires[k] == 7 : (at - std::floor(at) < 0.5) != (wires[k] > 2);
      found |= high << (2 - k);
    }
    return found;
  }

  // The lines until a clock, at which the motor is at a position that has grown by `rate` a clock since the last call.
  void look(double clock, double position, double rate) {
    const int now = lines(position);
    if (now != state) {
      double first = clock;
      while (state >= 0 && first > seen + 1 && lines(position - rate * (clock - first + 1)) == now) first -= 1;
      act(first);
      changed = first, pending = state = now;
      log.push_back(first), log.push_back(now);
    }
    seen = clock;
    act(clock);
  }

  void act(double clock) {
    const double then = changed + 4 + filter;
    if (pending < 0 || clock < then) return;
    static const int sectors[8] = {-1, 5, 3, 4, 1, 0, 2, -1};
    const int found = sectors[pending];
    pending = -1;
    const bool late = then - 1 - since >= limit;
    bad += found < 0 && !wrong;
    wrong = found < 0;
    if (wrong) {
      timed = moves = false;
    } else if (place < 0) {
      place = found, sector = found;
    } else if (found != place) {
      const int forward = (found - place + 6) % 6, way = forward > 3 ? forward - 6 : forward;
      const bool single = std::abs(way) == 1;
      moves = single && timed && (way < 0) == down && !late;
      span = then - since, since = edge = then, timed = single, down = way < 0;
      sector += way, place = found, bad += !single;
    }
  }

  int64_t count(double clock) {
    act(clock);
    if (clock > since + limit) timed = moves = false;
    const double part = moves ? std::min(std::floor((clock - edge) * size / span), size - 1) : size / 2;
    return sector * std::llround(size) + std::llround(moves && down ? size - 1 - part : part);
  }
};

struct Bench {
  servo::Parameters p;
  Frames frames;
  SineLines sines;
  Hall hall;
  double begun = 0;                                      // clocks before this half
  double off_square = 0, off_most = 0, off_samples = 0;  // of the counts from the position
  double inertia, load;  // kg or kg m2; constant force against positive motion
  double x = 0, v = 0, bristle = 0;
  servo::Windings windings;
  double compare[3] = {kHalf / 2., kHalf / 2., kHalf / 2.};
  Phase phases[3];
  double window, end, least;  // clocks of a half: windows begin, positions are sampled, PWM.minimum
  double first[2] = {}, second[2] = {};
  double weights[kBits] = {}, sum[2] = {}, sample[2] = {};
  int taken = -1, bits = 0, stepped = 0;  // bits of the window; bits since the last step of the mechanics
  double next_bit = 0, force = 0, since = 0;  // since: clocks from the last step
  double cosine = 1, sine = 0;                // of the angle there
  int64_t start, count_now = 0;
  bool up = true, gates = false, faulted = false;
  Tick tick = nullptr, outer = nullptr;
  float states[kStates] = {}, outer_states[kStates] = {}, outer_out[kOutputs] = {};
  uint32_t orders = 0, outer_orders = 0, every = 10, place = 0;

  const Axis& axis() const { return p.axis[0]; }
  double angle() const { return axis().wave * x + axis().angle_offset; }
  int64_t count() const { return std::llround(std::floor(x / axis().resolution + 0.5)); }

  void prepare() {
    double box[kBits + 2] = {};
    for (int n = 0; n < kRate; ++n) box[n] = 1;
    for (int pass = 0; pass < 2; ++pass) {
      double wide[kBits + 2] = {};
      for (int n = 0; n < kBits; ++n)
        for (int k = 0; k < kRate && n + k < kBits; ++k) wide[n + k] += box[n];
      std::copy(wide, wide + kBits, box);
    }
    std::copy(box, box + kBits, weights);
    start = hall.size > 0 ? 0 : count();
    cosine = std::cos(angle()), sine = std::sin(angle());
  }

  void order(Phase& phase, double clock) const {
    phase.ordered = !phase.ordered;
    phase.off = clock + p.delay_off / kClock;
    phase.on = clock + (p.dead_time + p.delay_on) / kClock;
  }

  bool ending(const Phase& phase, double current, double clocks) const {
    return !phase.high && !phase.low && std::fabs(current) * axis().L_q < 2 * p.U_dc * clocks * kClock;
  }

  // Windings from one clock of this half to another, from switch to switch.
  void solve(double now, double until, const double* edge) {
    const double w = axis().wave * v;
    double c, s;
    turned(w * since * kClock, c, s);
    while (now < until) {
      const auto current = windings.phases(c, s);
      double next = until, u[3], alpha, beta;
      for (int k = 0; k < 3; ++k) {
        Phase& phase = phases[k];
        if (gates && edge[k] <= now && phase.ordered == up) order(phase, edge[k]);
        if (phase.off <= now) phase.high = phase.low = false, phase.off = kNever;
        if (phase.on <= now) (phase.ordered ? phase.high : phase.low) = true, phase.on = kNever;
        for (const double at : {gates ? edge[k] : kNever, phase.off, phase.on})
          if (at > now) next = std::min(next, at);
      }
      for (int k = 0; k < 3; ++k)
        if (ending(phases[k], current[k], next - now)) next = std::min(next, now + kStep);
      const double time = (next - now) * kClock;
      for (int k = 0; k < 3; ++k)
        u[k] = servo::terminal(p, phases[k].high, phases[k].low, p.U_dc, current[k], axis().L_q, time);
      servo::space_vector(u, alpha, beta);
      windings.advance(axis(), alpha, beta, c, s, w, time);
      const double turn = w * time, before = c;
      c -= turn * s, s += turn * before;
      since += next - now;
      now = next;
    }
  }

  void step() {
    const double time = since * kClock;
    double total = force / stepped - servo::friction(axis(), bristle, v, time) - load;
    total += axis().cogging * std::sin(6 * (axis().wave * x + axis().angle_offset));
    v += time * total / inertia, x += time * v;
    force = 0, since = 0, stepped = 0;
    cosine = std::cos(angle()), sine = std::sin(angle());
  }

  // Cosine and sine of the electrical angle, a small one after the last step of the mechanics.
  void turned(double a, double& c, double& s) const {
    const double c1 = 1 - a * a / 2, s1 = a - a * a * a / 6;
    c = cosine * c1 - sine * s1;
    s = sine * c1 + cosine * s1;
  }

  void bit(double clock) {
    double c, s;
    turned(axis().wave * v * since * kClock, c, s);
    const auto current = windings.phases(c, s);
    const double gain[2] = {axis().gain_a, axis().gain_b}, offset[2] = {axis().offset_a, axis().offset_b};
    if (taken < 0 && clock >= window && clock < window + kBit) taken = 0, sum[0] = sum[1] = 0;
    for (int k = 0; k < 2; ++k) {
      const double shown = (current[k] * (1 + gain[k]) + offset[k]) / p.current_scale;
      const bool one = second[k] >= 0;
      const double back = one ? 1 : -1;
      first[k] = std::clamp(first[k] + shown - back, -8.0, 8.0);
      second[k] = std::clamp(second[k] + first[k] - 2 * back, -16.0, 16.0);
      if (taken >= 0 && one) sum[k] += weights[taken];
    }
    if (taken >= 0 && ++taken == kBits) {
      for (int k = 0; k < 2; ++k) sample[k] = sum[k] - kFull;
      taken = -1;
    }
    force += windings.force(axis());
    if (++stepped == kMechanics) look(clock), step();
  }

  static float word(double value) { return float(kMagic + std::nearbyint(value)); }

  // row: orders of the program, or of the outer one, whose first output then is the program's order; out: words
  // of the sample and the compare values that the run orders.
  void half(const float* row, float* out) {
    double edge[3];
    for (int k = 0; k < 3; ++k) {
      edge[k] = up ? compare[k] : kHalf - compare[k];
      if (gates && phases[k].ordered != (up ? compare[k] > 0 : compare[k] >= kHalf)) order(phases[k], 0);
    }
    double now = 0;
    bool sampled = false;
    float values[kOutputs] = {};
    while (now < kHalf) {
      const double until = std::min({next_bit, double(kHalf), sampled ? kNever : end, frames.next - begun});
      solve(now, until, edge);
      now = until;
      if (now == next_bit && now < kHalf) bit(now), next_bit += kBit;
      if (now == frames.next - begun) frames.act(begun + now), frames.instant(begun + now, seen() - start);
      if (!sampled && now >= end) run(row, values, out), sampled = true;
    }
    begun += kHalf;
    next_bit -= kHalf;
    for (Phase& phase : phases) phase.off -= kHalf, phase.on -= kHalf;
    for (int k = 0; k < 3; ++k) {  // as pwm_bound has it
      const double value = values[k] - kMagic;
      compare[k] = value < least ? 0 : value > kHalf - least ? kHalf : value;
    }
    up = !up;
  }

  void look(double clock) {
    if (hall.size > 0) hall.look(begun + clock, (x + v * since * kClock) / axis().resolution, v * kClock / axis().resolution);
  }

  // The position that the encoder gives; a sample that is lost counts no lines.
  int64_t seen() { return sines.size > 0 && !frames.lose ? sines.read((x + v * since * kClock) / axis().resolution) : whole(); }

  int64_t whole() const { return std::llround(std::floor((x + v * since * kClock) / axis().resolution + 0.5)); }

  void run(const float* row, float* values, float* out) {
    float in[kInputs] = {};
    if (frames.period > 0) {
      frames.act(begun + end);
      count_now = std::llround(frames.count(begun + end));
    } else if (hall.size > 0) {
      look(end);
      count_now = hall.count(begun + end);
    } else {
      count_now = whole() - start;
    }
    const double off = double(count_now + start) - (x + v * since * kClock) / axis().resolution;
    off_square += off * off, off_most = std::max(off_most, std::fabs(off)), off_samples += 1;
    in[0] = word(double(count_now));
    in[1] = word(sample[0]), in[2] = word(sample[1]), in[3] = kMagic;
    in[4] = word(p.U_dc / kBusScale);
    if (outer) {
      if (place++ % every == 0) {
        float outer_in[kInputs] = {float(count_now)};
        std::copy(row, row + outer_orders, outer_in + 1);
        faulted |= outer(outer_in, outer_states, outer_out) != 0;
      }
      in[5] = outer_out[0] + row[outer_orders];
    } else {
      std::copy(row, row + orders, in + 5);
    }
    faulted |= tick(in, states, values) != 0;
    out[0] = float(count_now), out[1] = in[1] - float(kMagic), out[2] = in[2] - float(kMagic);
    for (int k = 0; k < 3; ++k) out[3 + k] = values[k] - float(kMagic);
    out[6] = in[5];
  }
};

}  // namespace

extern "C" {

void* bench_new(const servo::Parameters* p, const double* rest) {
  auto* b = new Bench;
  b->p = *p;
  b->inertia = rest[0], b->load = rest[1], b->x = rest[2];
  b->window = rest[3], b->end = rest[4], b->least = rest[5];
  b->frames.period = rest[6], b->frames.late = rest[7];
  if (rest[6] > 0) b->frames.next = rest[6];
  if (rest[8] > 0) b->sines.size = std::exp2(rest[8]);
  b->sines.offset = rest[9], b->sines.gain = rest[10], b->sines.noise = rest[11];
  b->hall.size = rest[12], b->hall.filter = rest[13], b->hall.limit = rest[14], b->hall.error = rest[15];
  for (int k = 0; k < 3; ++k) b->hall.wires[k] = int(rest[16 + k]);
  b->prepare();
  return b;
}

void bench_free(void* handle) { delete static_cast<Bench*>(handle); }

// A program with its first states; orders: words of a row. The gates stay as they are.
void bench_load(void* handle, Tick tick, const float* states, uint32_t words, uint32_t orders) {
  auto* b = static_cast<Bench*>(handle);
  b->tick = tick, b->orders = orders, b->outer = nullptr;
  std::copy(states, states + words, b->states);
}

// A program that orders for the loaded one, every so many half periods; a row has its orders, and one that is
// added to what it orders.
void bench_outer(void* handle, Tick tick, const float* states, uint32_t words, uint32_t orders, uint32_t every) {
  auto* b = static_cast<Bench*>(handle);
  b->outer = tick, b->outer_orders = orders, b->every = every, b->place = 0;
  std::copy(states, states + words, b->outer_states);
}

void bench_gates(void* handle, int on) {
  auto* b = static_cast<Bench*>(handle);
  b->gates = on;
  for (Phase& phase : b->phases)
    if (!on) phase = Phase{};
}

// Half periods with a row of orders each; rows of 7: count, currents a and b [counts], compare values, order.
int bench_halves(void* handle, const float* rows, uint32_t width, float* out, uint32_t n) {
  auto* b = static_cast<Bench*>(handle);
  for (uint32_t i = 0; i < n; ++i, rows += width, out += 7) b->half(rows, out);
  return b->faulted;
}

// The next frames of the encoder are bad.
void bench_lose(void* handle, uint32_t frames) { static_cast<Bench*>(handle)->frames.lose = frames; }

// Illegal states and skipped sectors of Hall lines since the last call, as ILLEGAL has them; a state that is illegal
// now counts, as STATUS.illegal shows it.
uint32_t bench_bad(void* handle) {
  auto& hall = static_cast<Bench*>(handle)->hall;
  return std::max<uint32_t>(std::exchange(hall.bad, 0), hall.wrong);
}

// Clock and state of each change of the Hall lines; how many there are.
uint32_t bench_lines(void* handle, double* out, uint32_t most) {
  const auto& log = static_cast<Bench*>(handle)->hall.log;
  std::copy_n(log.begin(), std::min<size_t>(log.size(), 2 * most), out);
  return uint32_t(log.size() / 2);
}

// Distance of the sampled counts from the position since the last call, in counts: rms and largest.
void bench_off(void* handle, double* out) {
  auto* b = static_cast<Bench*>(handle);
  out[0] = std::sqrt(b->off_square / std::max(b->off_samples, 1.)), out[1] = b->off_most;
  b->off_square = b->off_most = b->off_samples = 0;
}

// What no estimator may see: position, speed, i_d, i_q, electrical angle where the count is 0.
void bench_truth(void* handle, double* out) {
  auto* b = static_cast<Bench*>(handle);
  out[0] = b->x, out[1] = b->v, out[2] = b->windings.i_d, out[3] = b->windings.i_q;
  out[4] = b->axis().wave * b->start * b->axis().resolution + b->axis().angle_offset;
}

}  // extern "C"
