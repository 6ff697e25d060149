// SPDX-License-Identifier: Apache-2.0
// Robot, motors, inverters, brakes and friction in double precision, SI units; axes are legs 1-3, tilt,
// rotation. Windings are exact between two switching edges: constant speed and terminal voltages make the
// circuit linear, and its matrix exponential is summed until nothing is added (sim/bench/drive/motor.py has the
// equations). The mechanics (sim/robot/plant.py) take Runge-Kutta steps with friction by LuGre, exact
// over a step of constant speed (sim/bench/drive/lugre.py).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace servo {

constexpr int kAxes = 5;
constexpr double kSqrt3 = 1.7320508075688772;
using Five = std::array<double, kAxes>;

struct Axis {
  double wave, R, L_d, L_q, psi, cogging;
  double coulomb, static_, speed, stiffness, damping, viscous;
  double resolution, angle_offset;        // of an encoder's count; electrical angle at position 0
  double brake_stiffness, brake_damping;  // of the closed holding brake
  double gain_a, gain_b, offset_a, offset_b;  // of the sensed currents
};

struct Parameters {
  double R, m_s, m_p, J_a, l_c, mr_c, J_44, J_55, m_4, r_4, g;
  double U_dc, dead_time, delay_on, delay_off, drop, drop_resistance, current_scale;
  Axis axis[kAxes];
};

// Currents and electrical state of one motor.
struct Windings {
  double i_d = 0, i_q = 0;

  // Terminals (alpha, beta) [V] for `time` [s]; c, s: cosine and sine of the electrical angle at the
  // beginning; w: electrical speed.
  void advance(const Axis& m, double alpha, double beta, double c, double s, double w, double time) {
    double d = i_d, q = i_q, u_d = alpha * c + beta * s, u_q = beta * c - alpha * s, psi = m.psi;
    for (int n = 1; n < 30; ++n) {
      const double h = time / n;
      const double d2 = h * ((u_d - m.R * d + w * m.L_q * q) / m.L_d);
      const double q2 = h * ((u_q - m.R * q - w * m.L_d * d - w * psi) / m.L_q);
      const double v_d = h * w * u_q, v_q = -h * w * u_d;
      d = d2, q = q2, u_d = v_d, u_q = v_q, psi = 0;
      i_d += d, i_q += q;
      if (std::fabs(d) + std::fabs(q) < 1e-17) break;
    }
  }

  // Phase k opens: its current is gone, by a voltage of that phase alone. c, s as above, now.
  void open(const Axis& m, int k, double c, double s) {
    const double a = k == 0 ? 1 : -0.5, b = k == 0 ? 0 : (k == 1 ? 0.5 : -0.5) * kSqrt3;
    const double d = a * c + b * s, q = b * c - a * s;
    const double push = (i_d * d + i_q * q) / (d * d / m.L_d + q * q / m.L_q);
    i_d -= push * d / m.L_d;
    i_q -= push * q / m.L_q;
  }

  double force(const Axis& m) const { return 1.5 * m.wave * (m.psi * i_q + (m.L_d - m.L_q) * i_d * i_q); }

  std::array<double, 3> phases(double c, double s) const {
    const double alpha = i_d * c - i_q * s, beta = i_d * s + i_q * c;
    const double b = (-alpha + kSqrt3 * beta) / 2;
    return {alpha, b, -alpha - b};
  }
};

// Mean force of LuGre friction over `time`; z: deflection of the bristles.
inline double friction(const Axis& f, double& z, double v, double time) {
  if (v == 0 || f.stiffness == 0) return f.stiffness * z + f.viscous * v;
  const double fall = std::exp(-(v / f.speed) * (v / f.speed));
  const double level = f.coulomb + (f.static_ - f.coulomb) * fall;
  const double turns = f.stiffness * std::fabs(v) / level * time;
  const double end = std::copysign(level / f.stiffness, v), share = -std::expm1(-turns);
  const double after = z + (end - z) * share;
  const double mean = turns > 1e-9 ? end - (end - z) * share / turns : z;
  const double force = f.stiffness * mean + f.damping * (after - z) / time + f.viscous * v;
  z = after;
  return force;
}

// Tool and table.
class Mechanics {
 public:
  Five q{}, v{};  // x, y, z, tilt, rotation
  Five z{};       // bristles of the joints

  void place(const Parameters& p, const Five& at, const Five& rates = {}) {
    q = at;
    v = rates;
    z = {};
    joints(p, position, speed);
    held = position;
  }

  Five position{}, speed{};  // of the joints: legs, tilt, rotation
  Five held{};               // where a closed brake caught its joint

  // Joint forces of the motors over `time`; released: bit n of axis n's brake.
  void advance(const Parameters& p, const Five& motor, uint32_t released, double time) {
    Five force;
    for (int n = 0; n < kAxes; ++n) {
      const Axis& a = p.axis[n];
      force[n] = motor[n] - friction(a, z[n], speed[n], time);
      force[n] += a.cogging * std::sin(6 * (a.wave * position[n] + a.angle_offset));
      if (released >> n & 1) held[n] = position[n];
      else force[n] -= a.brake_stiffness * (position[n] - held[n]) + a.brake_damping * speed[n];
    }
    const double half = time / 2;
    const Five a1 = rates(p, q, v, force), v2 = moved(v, half, a1);
    const Five a2 = rates(p, moved(q, half, v), v2, force), v3 = moved(v, half, a2);
    const Five a3 = rates(p, moved(q, half, v2), v3, force), v4 = moved(v, time, a3);
    const Five a4 = rates(p, moved(q, time, v3), v4, force);
    q = moved(q, time / 6, weighted(v, v2, v3, v4));
    v = moved(v, time / 6, weighted(a1, a2, a3, a4));
    joints(p, position, speed);
  }

  // Joints that a test bench moves at constant speeds; tool and table stay where they are.
  void spin(const Five& speeds, double time) {
    position = moved(position, time, speeds);
    speed = speeds;
  }

  static Five rates(const Parameters& p, const Five& q, const Five& v, const Five& force) {
    const double u = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    double diagonal = p.m_p, m_z = p.m_p, along = 0;
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, bx = 0, by = 0, bz = 0;
    for (int n = 0; n < 3; ++n) {
      const double rx = q[0] - foot_x(p, n), ry = q[1] - foot_y(p, n);
      const double length = std::sqrt(rx * rx + ry * ry + q[2] * q[2]);
      const double wx = rx / length, wy = ry / length, wz = q[2] / length;
      const double s = wx * v[0] + wy * v[1] + wz * v[2], s2 = s * s, reach = length - p.l_c;
      const double inertia = (p.J_a + p.m_s * reach * reach) / (length * length);
      const double slope = 2 * (p.m_s * reach / length - inertia) / length, across = p.m_s - inertia;
      diagonal += inertia;
      m_z += (p.m_s * reach - p.mr_c) / length;
      xx += across * wx * wx, xy += across * wx * wy, xz += across * wx * wz;
      yy += across * wy * wy, yz += across * wy * wz, zz += across * wz * wz;
      const double push = force[n] - (across * (u - s2) / length - 0.5 * slope * (u + s2));
      along += slope * s;
      bx += push * wx, by += push * wy, bz += push * wz;
    }
    bx -= along * v[0], by -= along * v[1], bz -= along * v[2] + m_z * p.g;
    xx += diagonal, yy += diagonal, zz += diagonal;
    const double axx = yy * zz - yz * yz, axy = xz * yz - xy * zz, axz = xy * yz - xz * yy;
    const double ayy = xx * zz - xz * xz, ayz = xy * xz - xx * yz, azz = xx * yy - xy * xy;
    const double scale = 1 / (xx * axx + xy * axy + xz * axz);
    return {(axx * bx + axy * by + axz * bz) * scale, (axy * bx + ayy * by + ayz * bz) * scale,
            (axz * bx + ayz * by + azz * bz) * scale,
            (force[3] - p.r_4 * p.m_4 * p.g * std::sin(q[3])) / p.J_44, force[4] / p.J_55};
  }

 private:
  static double foot_x(const Parameters& p, int n) { return n == 0 ? 0 : (n == 1 ? 0.5 : -0.5) * kSqrt3 * p.R; }
  static double foot_y(const Parameters& p, int n) { return n == 0 ? p.R : -0.5 * p.R; }

  void joints(const Parameters& p, Five& at, Five& rate) const {
    for (int n = 0; n < 3; ++n) {
      const double rx = q[0] - foot_x(p, n), ry = q[1] - foot_y(p, n);
      at[n] = std::sqrt(rx * rx + ry * ry + q[2] * q[2]);
      rate[n] = (rx * v[0] + ry * v[1] + q[2] * v[2]) / at[n];
    }
    for (int n = 3; n < kAxes; ++n) at[n] = q[n], rate[n] = v[n];
  }

  static Five moved(const Five& start, double time, const Five& rate) {
    Five to;
    for (int n = 0; n < kAxes; ++n) to[n] = start[n] + time * rate[n];
    return to;
  }

  static Five weighted(const Five& a, const Five& b, const Five& c, const Five& d) {
    Five sum;
    for (int n = 0; n < kAxes; ++n) sum[n] = a[n] + 2 * (b[n] + c[n]) + d[n];
    return sum;
  }
};

// A phase's terminal against the bus's middle, for `time` [s]; bus [V]. Without a switch a diode conducts until
// its current is gone.
inline double terminal(const Parameters& p, bool high, bool low, double bus, double current, double inductance,
                       double time) {
  const double drop = std::copysign(p.drop, current) + p.drop_resistance * current;
  const double most = bus / 2 + std::fabs(drop);
  if (high) return bus / 2 - drop;
  if (low) return -bus / 2 - drop;
  return std::clamp(-current * inductance / time, -most, most);
}

// Phase voltages against their mean, as (alpha, beta).
inline void space_vector(const double* u, double& alpha, double& beta) {
  alpha = (2 * u[0] - u[1] - u[2]) / 3;
  beta = (u[1] - u[2]) / kSqrt3;
}

}  // namespace servo
