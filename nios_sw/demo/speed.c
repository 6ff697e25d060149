/* SPDX-License-Identifier: Apache-2.0 */
/* Speed control on a timer interrupt: a PI law in single precision, the motor modelled next to it. */
#include <stdio.h>

#include "arithmetic.h"
#include "io.h"

#define PERIOD_US 100
#define T_S (PERIOD_US * 1e-6f) /* s */
#define TIME_CONSTANT 0.020f    /* s, of the motor */
#define GAIN 10.0f              /* rad/s per V, of the motor */
#define K_P 0.5f
#define K_I 25.0f
#define U_MAX 48.0f /* V */

static const float wanted = 100.0f; /* rad/s */
static volatile float speed;        /* rad/s */
static volatile uint32_t ticks, longest;

static void control(void) {
  static float integral;
  uint32_t begin = cycle_now();
  float error = wanted - speed;
  float u = saturate(K_P * error + integral, U_MAX);

  if (u < U_MAX && u > -U_MAX) integral += K_I * T_S * error;
  speed += T_S / TIME_CONSTANT * (GAIN * u - speed);
  ++ticks;
  uint32_t cycles = cycle_now() - begin;
  if (cycles > longest) longest = cycles;
}

int main(void) {
  timer_start(PERIOD_US * CLOCK_MHZ, control);
  for (uint32_t ms = 10; ms <= 50; ms += 10) {
    while (ticks < 1000 / PERIOD_US * ms) {
    }
    printf("%2lu ms: %.2f rad/s\n", ms, speed);
  }
  timer_stop();
  printf("longest tick: %lu cycles of %d\n", longest, PERIOD_US * CLOCK_MHZ);
  return 0;
}
