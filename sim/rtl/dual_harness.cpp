// SPDX-License-Identifier: Apache-2.0
// C interface of the Verilated two-processor system; the caller gives the measured words of each period.
#include "Vdual_asip.h"
#include "dual_bench.h"

namespace {

struct System : DualBench<System, Vdual_asip> {
  System() {
    for (uint32_t i = 0; i < kMeasured; ++i) top->measured_i[i] = 0;
    begin();
  }

  // While the work of a period is under way, the lines hold the complements, except for the first clock.
  void measure(Period* p, bool steady) {
    for (uint32_t i = 0; i < kMeasured; ++i)
      top->measured_i[i] = steady ? p->measured[i] : ~p->measured[i];
  }
};

}  // namespace

#include "dual_api.h"
