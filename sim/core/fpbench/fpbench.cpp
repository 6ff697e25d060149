// SPDX-License-Identifier: Apache-2.0
// Fast bench of an arithmetic unit: streams cases through the Verilated lanes of fpbench.sv, compares
// results and flags with the host's arithmetic. Interface in C, called by sim/core/fpbench/native.py.
// Contract: an operation issued in one clock must answer exactly latency_o clocks later, in order;
// anything else is a protocol error and ends the run. A function returns 0, or -1 for a bad request.
#include <ctime>

#include "../../rtl/bench.h"
#include "Vfpbench.h"
#include "angles.h"
#include "cases.h"
#include "operations.h"

using operations::Operation;
using reference::u32;
using reference::u64;
using reference::u8;

extern "C" {

constexpr int SHOWN = 16;

struct Failure {
  u32 a, b, c, got, want;
  u8 got_flags, want_flags, pad[2];
};

struct Report {
  u64 cases, mismatches, cycles;
  double seconds;  // processor time of this thread
  char protocol[96];
  u32 shown, pad;
  Failure failures[SHOWN];
  angles::Statistics angles;
};
}

namespace {

constexpr u64 BLOCK = 16384;

struct Columns {
  alignas(64) u32 a[BLOCK], b[BLOCK], c[BLOCK], got[BLOCK], want[BLOCK];
  alignas(64) u8 got_flags[BLOCK], want_flags[BLOCK];
};

double processor_time() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

class Lanes : public Bench<Lanes, Vfpbench> {
 public:
  Lanes() {
    top->rst_ni = 0;
    top->valid_i = 0;
    clock();
    top->rst_ni = 1;
    clock();
    lanes_ = int(top->lanes_o);
    latency_ = top->latency_o;
    all_ = lanes_ == 64 ? ~u64(0) : (u64(1) << lanes_) - 1;
  }

  // One block through the pipeline and out again. Gaps: idle clocks with random operands between.
  bool stream(unsigned control, u64 n, Columns &d, cases::Random &idle, bool gaps, Report &report) {
    const u64 rows = (n + lanes_ - 1) / lanes_;
    u64 sent = 0, done = 0, cycle = 0, gap_bits = 0;
    issued_.resize(rows);
    top->control_i = control;
    while (done < rows) {
      if (gaps && !(cycle & 63)) gap_bits = idle.next() & idle.next();
      const bool ready = top->ready_o == all_;
      const bool issue = sent < rows && ready && !(gap_bits >> (cycle & 63) & 1);
      top->valid_i = issue;
      if (issue) {
        const u64 at = sent * u64(lanes_);
        for (int k = 0; k < lanes_; k++) {
          top->a_i[k] = d.a[at + k];
          top->b_i[k] = d.b[at + k];
          top->c_i[k] = d.c[at + k];
        }
        issued_[sent++] = cycle;
      } else {  // nothing of an idle clock may show in a result
        const u64 noise = idle.next();
        for (int k = 0; k < lanes_; k++) {
          top->a_i[k] = u32(noise) * u32(2 * k + 1);
          top->b_i[k] = u32(noise >> 32) * u32(2 * k + 1);
          top->c_i[k] = u32(noise >> 16);
        }
      }
      clock();
      cycle++;
      if (cycle > 2 * (rows + 64) * (latency_ + 2)) {
        std::snprintf(report.protocol, sizeof report.protocol, "the unit is never ready again");
        return false;
      }
      const u64 valid = top->valid_o;
      const bool due = done < sent && issued_[done] + latency_ == cycle;
      if (valid != (due ? all_ : 0)) {
        std::snprintf(report.protocol, sizeof report.protocol,
                      "clock %llu of a block: %s; the latency is %u clocks", (unsigned long long)cycle,
                      due ? "a result is missing" : "valid_o without a result due", latency_);
        return false;
      }
      if (due) {
        const u64 at = done++ * u64(lanes_);
        for (int k = 0; k < lanes_; k++) {
          d.got[at + k] = top->result_o[k];
          d.got_flags[at + k] = top->flags_o[k];
        }
      }
    }
    top->valid_i = 0;
    report.cycles += cycle;
    return true;
  }

 private:
  void clock() {
    rise();
    settle();
  }

  std::vector<u64> issued_;
  int lanes_ = 1;
  u32 latency_ = 0;
  u64 all_ = 1;
};

void fail(Report &report, const Columns &d, u64 i) {
  report.mismatches++;
  if (report.shown == SHOWN) return;
  report.failures[report.shown++] = {d.a[i], d.b[i], d.c[i], d.got[i], d.want[i],
                                     d.got_flags[i], d.want_flags[i], {0, 0}};
}

// The loop over a block is compiled once per operation, with the reference inlined.
void expect(const Operation &o, u64 n, Columns &d) {
  const auto f = o.reference;
  for (u64 i = 0; i < n; i++) {
    const auto v = f(d.a[i], d.b[i], d.c[i]);
    d.want[i] = v.bits;
    d.want_flags[i] = v.flags;
  }
}

void compare(const Operation &o, u64 n, Columns &d, Report &report) {
  expect(o, n, d);
  u64 different = 0;
  for (u64 i = 0; i < n; i++)
    different += (d.got[i] != d.want[i]) | (d.got_flags[i] != d.want_flags[i]);
  if (!different) return;
  for (u64 i = 0; i < n; i++)
    if (d.got[i] != d.want[i] || d.got_flags[i] != d.want_flags[i]) fail(report, d, i);
}

void judge(const Operation &o, u64 n, double bound, Columns &d, Report &report) {
  const bool cosine = o.control & 1;
  angles::Statistics &s = report.angles;
  for (u64 i = 0; i < n; i++) {
    bool good = angles::judge(cosine, d.a[i], d.got[i], d.got_flags[i], bound, s, d.want[i],
                              d.want_flags[i]);
    if (i & 1 && (d.a[i] ^ d.a[i - 1]) == reference::SIGN) {  // sine is odd, cosine even
      const u32 flip = !cosine && !reference::is_nan(d.got[i]) ? reference::SIGN : 0;
      s.symmetric_pairs++;
      if (d.got[i] != (d.got[i - 1] ^ flip)) {
        if (good) d.want[i] = d.got[i - 1] ^ flip;
        good = false;
      }
    }
    if (!good) fail(report, d, i);
  }
}

// Results of the unit, for the caller who wants them; null pointers otherwise.
struct Observed {
  u32 *bits;
  u8 *flags;
};

void run(const Operation &o, cases::Source *source, const u32 *list, u64 listed, u64 seed, bool gaps,
         double bound, Report &report, Observed observed = {nullptr, nullptr}) {
  thread_local std::unique_ptr<Columns> columns(new Columns());
  Columns &d = *columns;
  Lanes bench;
  cases::Random idle(seed ^ 0x5eed);
  const double begin = processor_time();
  for (;;) {
    u64 n;
    if (source) {
      n = source->fill(BLOCK, d.a, d.b, d.c);
    } else {
      n = std::min(BLOCK, listed);
      for (u64 i = 0; i < n; i++, list += 3) d.a[i] = list[0], d.b[i] = list[1], d.c[i] = list[2];
      listed -= n;
    }
    if (!n) break;
    // Operands that the operation does not have must not matter.
    const u64 salt = idle.next();
    for (u64 i = 0; o.operands < 3 && i < n; i++) d.c[i] = u32(i + salt) * 2654435761u;
    for (u64 i = 0; o.operands < 2 && i < n; i++) d.b[i] = u32(i + (salt >> 32)) * 2246822519u;
    if (!bench.stream(o.control, n, d, idle, gaps, report)) break;
    if (o.reference) compare(o, n, d, report);
    else judge(o, n, bound, d, report);
    if (observed.bits) {
      std::copy(d.got, d.got + n, observed.bits + report.cases);
      std::copy(d.got_flags, d.got_flags + n, observed.flags + report.cases);
    }
    report.cases += n;
  }
  report.seconds = processor_time() - begin;
}

}  // namespace

extern "C" {

// Operation `index` of the table: its name, unit and operand count; 0 when the table ends.
unsigned fpbench_operation(unsigned index, const char **name, const char **unit) {
  if (index >= sizeof operations::TABLE / sizeof operations::TABLE[0]) return 0;
  const Operation &o = operations::TABLE[index];
  *name = o.name;
  *unit = o.unit;
  return o.operands;
}

u64 fpbench_size(const char *op, const char *kind) {
  const Operation *o = operations::find(op);
  return o ? cases::size(*o, kind) : 0;
}

size_t fpbench_report_size() { return sizeof(Report); }

int fpbench_run(const char *op, const char *kind, u64 start, u64 count, u64 seed, int gaps, double bound,
                Report *report) {
  *report = {};
  const Operation *o = operations::find(op);
  if (!o || std::string(o->unit) != FPBENCH_UNIT) return -1;
  const u64 size = cases::size(*o, kind);
  if (start >= size || count > size - start) return -1;
  cases::Source source(*o, kind, start, count, seed);
  run(*o, &source, nullptr, 0, seed, gaps, bound, *report);
  return 0;
}

// `list`: rows of three operands. What the unit answered goes to `bits` and `flags`.
int fpbench_run_list(const char *op, const u32 *list, u64 count, double bound, u32 *bits, u8 *flags,
                     Report *report) {
  *report = {};
  const Operation *o = operations::find(op);
  if (!o || std::string(o->unit) != FPBENCH_UNIT) return -1;
  run(*o, nullptr, list, count, 1, false, bound, *report, {bits, flags});
  return 0;
}

// The operands themselves, rows of three, and what the reference says of them; returns the number.
u64 fpbench_operands(const char *op, const char *kind, u64 start, u64 count, u64 seed, u32 *rows) {
  const Operation *o = operations::find(op);
  if (!o || start >= cases::size(*o, kind) || count > cases::size(*o, kind) - start) return 0;
  cases::Source source(*o, kind, start, count, seed);
  auto d = std::make_unique<Columns>();
  u64 total = 0;
  while (u64 n = source.fill(BLOCK, d->a, d->b, d->c))
    for (u64 i = 0; i < n; i++, total++)
      rows[3 * total] = d->a[i], rows[3 * total + 1] = d->b[i], rows[3 * total + 2] = d->c[i];
  return total;
}

int fpbench_reference(const char *op, const u32 *rows, u64 count, u32 *bits, u8 *flags) {
  const Operation *o = operations::find(op);
  if (!o || !o->reference) return -1;
  for (u64 i = 0; i < count; i++) {
    const auto v = o->reference(rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]);
    bits[i] = v.bits;
    flags[i] = v.flags;
  }
  return 0;
}

// The double-precision value that angles.h measures against.
double fpbench_exact(int cosine, u32 a) { return angles::exact(cosine, a); }
}
