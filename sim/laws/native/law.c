/* SPDX-License-Identifier: Apache-2.0 */
/* Runs and times the C of a law on this machine: sim/laws/native/law.py. LAW: its prefix,
 * LAW_HEADER: its header. Rows are the words of its structures. */
#define _GNU_SOURCE
#include <math.h>
#include <sched.h>
#include <string.h>
#include <time.h>

#include LAW_HEADER

#define JOIN(a, b) a##b
#define NAME(law, what) JOIN(law, what)
typedef struct NAME(LAW, _inputs) inputs;
typedef struct NAME(LAW, _states) states;
typedef struct NAME(LAW, _outputs) outputs;

/* n ticks from `state`; outputs, states and results of each. */
void run(long n, const inputs *in, states *state, outputs *out, states *after, int32_t *result) {
  for (long i = 0; i < n; ++i) {
    result[i] = NAME(LAW, _tick)(&in[i], state, &out[i]);
    after[i] = *state;
  }
}

static int64_t now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1000000000ll * t.tv_sec + t.tv_nsec;
}

/* Nanoseconds of each of n ticks, inputs in turn from `rows` rows, and of reading the clock alone.
 * cpu: the processor to stay on, -1 for any. Returns 0, or -1 if the processor cannot be had. */
int time_ticks(long n, long rows, const inputs *in, int cpu, int32_t *tick, int32_t *clock) {
  cpu_set_t one, before;
  states state = NAME(LAW, _initial);
  outputs out;
  volatile int32_t sink = 0;

  sched_getaffinity(0, sizeof before, &before);
  if (cpu >= 0) {
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    if (sched_setaffinity(0, sizeof one, &one)) return -1;
  }
  for (long i = 0, row = 0; i < n; ++i, row = row + 1 < rows ? row + 1 : 0) {
    int64_t begin = now();
    int64_t again = now();
    int bad = NAME(LAW, _tick)(&in[row], &state, &out);
    int64_t end = now();
    int32_t word;
    memcpy(&word, &out, sizeof word);
    sink = sink ^ word ^ bad;
    clock[i] = (int32_t)(again - begin);
    tick[i] = (int32_t)(end - again);
  }
  if (cpu >= 0) sched_setaffinity(0, sizeof before, &before);
  return 0;
}

/* Sines or cosines of n angles by the C library, for the comparison of bits. */
void sines(long n, const float *angle, int cosine, float *result) {
  for (long i = 0; i < n; ++i) {
    result[i] = fabsf(angle[i]) <= 256.0f ? cosine ? cosf(angle[i]) : sinf(angle[i]) : NAN;
  }
}
