// SPDX-License-Identifier: Apache-2.0
// Windings, friction and a phase's terminal of sim/bench/drive/plant.h as functions (test_plant.py).
#include "plant.h"

extern "C" {

// currents: i_d, i_q, before and after; angle: of the rotor at the beginning [rad]; w: its electrical speed.
void windings_advance(const servo::Axis* axis, double* currents, double alpha, double beta, double angle, double w,
                      double time) {
  servo::Windings windings{currents[0], currents[1]};
  windings.advance(*axis, alpha, beta, std::cos(angle), std::sin(angle), w, time);
  currents[0] = windings.i_d;
  currents[1] = windings.i_q;
}

// Force of the motor, and the currents of its phases.
double windings_force(const servo::Axis* axis, const double* currents, double angle, double* phases) {
  const servo::Windings windings{currents[0], currents[1]};
  const auto found = windings.phases(std::cos(angle), std::sin(angle));
  std::copy(found.begin(), found.end(), phases);
  return windings.force(*axis);
}

// Mean force over `time`; z: deflection, before and after.
double friction_step(const servo::Axis* axis, double* z, double v, double time) {
  return servo::friction(*axis, *z, v, time);
}

// Voltage of a phase of an inverter against the middle of its bus.
double terminal_voltage(const servo::Parameters* plant, int high, int low, double current, double inductance,
                        double time) {
  return servo::terminal(*plant, high, low, plant->U_dc, current, inductance, time);
}

}  // extern "C"
