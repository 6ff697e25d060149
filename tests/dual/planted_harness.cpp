// SPDX-License-Identifier: Apache-2.0
// The harness of the two-processor system for a model with planted faults: says which one is chosen.
#include <cstdlib>

#include "dual_harness.cpp"

extern "C" int planted_fault() {
  const char* number = std::getenv("PLANTED_FAULT");
  return number ? std::atoi(number) : 0;
}
