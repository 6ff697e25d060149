/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the C that asip-model writes of a law over rows of inputs in memory, and counts the cycles of
 * each tick (sim/bench/platforms/nios.py). LAW: its prefix, LAW_HEADER: its header, ROWS: room for rows. */
#include "io.h"
#include LAW_HEADER

#define JOIN(a, b) a##b
#define NAME(law, what) JOIN(law, what)

/* Written by the host before the start: how many rows, the first states, the inputs. */
struct law_run {
  int32_t rows;
  struct NAME(LAW, _states) state;
  struct NAME(LAW, _inputs) in[ROWS];
  struct NAME(LAW, _outputs) out[ROWS];
  struct NAME(LAW, _states) after[ROWS];
  int32_t result[ROWS];
  uint32_t cycles[ROWS]; /* of the call, without those of reading the counter */
};
/* In .sdata because start-up clears .sbss. */
struct law_run law_run __attribute__((section(".sdata")));

int main(void) {
  for (int32_t i = 0; i < law_run.rows; ++i) {
    uint32_t before = cycle_now();
    uint32_t begin = cycle_now();
    int result = NAME(LAW, _tick)(&law_run.in[i], &law_run.state, &law_run.out[i]);
    uint32_t end = cycle_now();
    law_run.result[i] = result;
    law_run.cycles[i] = (end - begin) - (begin - before);
    law_run.after[i] = law_run.state;
  }
  return 0;
}
