// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated step interpolator: one job, all its steps (interpolator_rtl.py).
#include <cstdint>

#include "Vstep_interpolator.h"
#include "bench.h"

namespace {

struct Interpolator : Bench<Interpolator, Vstep_interpolator> {
  Interpolator() {
    top->start_i = top->advance_i = 0;
    reset(1);
  }
};

}  // namespace

extern "C" {

void* interpolator_new() { return new Interpolator; }
void interpolator_delete(void* handle) { delete static_cast<Interpolator*>(handle); }

// job: arc, plane, combined, clockwise, turns, start u v, end u v, start error. A step is a byte
// {negative z y x, step z y x}. Returns the steps made, at most n + 1; `pause` clocks pass between
// requests.
uint64_t interpolator_run(void* handle, const int32_t* job, uint8_t* steps, uint64_t n, int pause) {
  Vstep_interpolator& t = *static_cast<Interpolator*>(handle)->top;
  t.arc_i = job[0];
  t.plane_i = job[1];
  t.combined_i = job[2];
  t.clockwise_i = job[3];
  t.turns_i = job[4];
  t.start_u_i = job[5] & 0xFFFFFF;
  t.start_v_i = job[6] & 0xFFFFFF;
  t.end_u_i = job[7] & 0xFFFFFF;
  t.end_v_i = job[8] & 0xFFFFFF;
  t.start_error_i = job[9] & 0xFFFFFF;
  t.start_i = 1;
  static_cast<Interpolator*>(handle)->clock();
  t.start_i = 0;
  uint64_t count = 0;
  int wait = 0;
  while (t.active_o && count <= n) {
    t.advance_i = t.ready_o && wait == 0;
    wait = t.advance_i ? pause : wait - (wait > 0);
    static_cast<Interpolator*>(handle)->clock();
    if (t.valid_o) {
      if (count < n) steps[count] = t.negative_o << 3 | t.step_o;
      ++count;
    }
  }
  t.advance_i = 0;
  return count;
}

}  // extern "C"
