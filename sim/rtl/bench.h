// SPDX-License-Identifier: Apache-2.0
// Base of the C++ harnesses: a Verilated model with its clock, reset, Avalon-MM accesses and waves.
// A harness derives `struct X : Bench<X, Vtop>` and may replace settle(), edge() and clock().
//
// Waves are compiled in with VM_TRACE only, of which verilated.h makes WAVES. Each model then writes
// <WAVES_FOLDER>/<top>-<n>.fst, 8 ns a clock, the first WAVES_CLOCKS clocks (default 1 000 000);
// bench_close_waves ends the files, and what a model does later goes to a new one.
//
// With VM_COVERAGE a model writes what it counted to <RTL_COVERAGE_FOLDER>/<top>-<process>-<n>.dat at its end.
#pragma once
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "verilated.h"

#if VM_COVERAGE
#include <unistd.h>

#include <cstdlib>
#include <set>
#include <string>

#include "verilated_cov.h"

class Coverage {
 public:
  Coverage(VerilatedContext& context, const char* name) : context_(context), name_(name) {
    static const bool once = std::atexit(write_all) == 0;
    (void)once;
    all().insert(this);
  }
  ~Coverage() {
    if (all().erase(this)) write();
  }

 private:
  // Models that nobody frees write at the end of the process.
  static void write_all() {
    for (Coverage* coverage : all()) coverage->write();
    all().clear();
  }

  static std::set<Coverage*>& all() {
    static auto* those = new std::set<Coverage*>;
    return *those;
  }

  void write() {
    static int number = 0;
    const char* folder = std::getenv("RTL_COVERAGE_FOLDER");
    const std::string path = std::string(folder && *folder ? folder : ".") + "/" + name_ + "-" +
                             std::to_string(getpid()) + "-" + std::to_string(++number) + ".dat";
    context_.coveragep()->write(path);
  }

  VerilatedContext& context_;
  std::string name_;
};
#endif

#ifdef WAVES
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

#include "verilated_fst_c.h"

class Waves {
 public:
  Waves() {
    static const bool once = (before_abort() = std::signal(SIGABRT, aborted), true);
    (void)once;
    all().insert(this);
  }
  ~Waves() {
    close();
    all().erase(this);
  }

  template <typename Model>
  void dump(Model& top, const char* name, uint64_t clocks, uint64_t half) {
    if (!file_) begin(top, name, clocks);
    if (clocks - begun_at_ < most_) file_->dump(time(clocks, half));
  }

  // In ns, in the present file.
  uint64_t time(uint64_t clocks, uint64_t half) const { return 8 * (clocks - begun_at_) + 4 * half; }

  void close() {
    if (file_) file_->close();
    file_.reset();
  }

  static void close_all() {
    for (Waves* waves : all()) waves->close();
  }

 private:
  // A failing assertion aborts the process; its file is to be whole.
  static void aborted(int number) {
    close_all();
    if (before_abort() != SIG_DFL && before_abort() != SIG_IGN) before_abort()(number);
  }

  static void (*&before_abort())(int) {
    static void (*before)(int) = SIG_DFL;
    return before;
  }

  static std::set<Waves*>& all() {
    static std::set<Waves*> those;
    return those;
  }

  template <typename Model>
  void begin(Model& top, const char* name, uint64_t clocks) {
    const char* folder = std::getenv("WAVES_FOLDER");
    const char* most = std::getenv("WAVES_CLOCKS");
    most_ = most && *most ? std::strtoull(most, nullptr, 10) : 1000000;
    std::string path;
    std::FILE* taken = nullptr;
    for (int n = 1; n < 10000 && !taken; ++n) {
      path = std::string(folder && *folder ? folder : ".") + "/" + name + "-" + std::to_string(n) + ".fst";
      taken = std::fopen(path.c_str(), "wx");
    }
    if (!taken) {
      std::fprintf(stderr, "error: %s cannot be written; set WAVES_FOLDER\n", path.c_str());
      std::exit(1);
    }
    std::fclose(taken);
    file_.reset(new VerilatedFstC);  // a second file of one object would fail on the types of enums
    top.trace(file_.get(), 99);
    begun_at_ = clocks;
    file_->open(path.c_str());
  }

  std::unique_ptr<VerilatedFstC> file_;
  uint64_t begun_at_ = 0, most_ = 0;
};

extern "C" inline __attribute__((visibility("default"), used)) void bench_close_waves() {
  Waves::close_all();
}
#endif

template <typename Self, typename Model>
class Bench {
 public:
  VerilatedContext context;
  std::unique_ptr<Model> top;
  uint64_t clocks = 0;  // rising edges so far

  Bench() {
#ifdef WAVES
    context.traceEverOn(true);
    context.timeunit(-9);
    context.timeprecision(-9);
#endif
    top.reset(new Model(&context));
    top->clk_i = 0;
#if VM_COVERAGE
    coverage_.reset(new Coverage(context, top->modelName() + 1));
#endif
  }

  // The destructor of a model uses the context of the thread, not its own. Unless it is set here, it
  // belongs to the model that was made last, which may be freed already.
  ~Bench() { Verilated::threadContextp(&context); }

  // A clock in two halves: inputs settle, then the rising edge.
  void settle() {
    top->clk_i = 0;
    top->eval();
  }

  void rise() {
#ifdef WAVES
    top->eval();  // a harness may have set inputs
    waves_.dump(*top, top->modelName() + 1, clocks, 0);
    context.time(waves_.time(clocks, 1));  // of what an assertion says
#endif
    top->clk_i = 1;
    top->eval();
#ifdef WAVES
    waves_.dump(*top, top->modelName() + 1, clocks, 1);
#endif
    ++clocks;
  }

  void edge() { rise(); }

  void clock() {
    self().settle();
    self().edge();
  }

  // Holds the reset for some clocks; some without it follow.
  void reset(int held = 4, int after = 1) {
    top->rst_ni = 0;
    for (int i = 0; i < held; ++i) self().clock();
    top->rst_ni = 1;
    for (int i = 0; i < after; ++i) self().clock();
  }

  // One Avalon-MM access of a word; false if it is not answered within `limit` clocks.
  bool access(uint32_t address, uint32_t* data, bool is_write, uint64_t limit = 1000000) {
    top->address_i = address;
    top->writedata_i = is_write ? *data : 0;
    top->write_i = is_write;
    top->read_i = !is_write;
    bool accepted = false;
    for (uint64_t n = 0; n < limit && !accepted; ++n) {
      self().settle();
      accepted = !top->waitrequest_o;
      if (accepted && !is_write) *data = top->readdata_o;
      self().edge();
    }
    top->write_i = 0;
    top->read_i = 0;
    return accepted;
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
#ifdef WAVES
  Waves waves_;
#endif
#if VM_COVERAGE
  std::unique_ptr<Coverage> coverage_;  // freed before the model
#endif
};

// xorshift64* (S. Vigna, 2016), from a seed.
class Random {
 public:
  explicit Random(uint64_t seed = 0) : state_(seed * 2 + 1) {}

  uint32_t draw() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return (state_ * 2685821657736338717ull) >> 32;
  }

 private:
  uint64_t state_;
};

// Copies at most n events as words; returns how many there are.
template <typename Event>
uint32_t copy_events(const std::vector<Event>& events, uint32_t* words, uint32_t n) {
  const uint32_t count = events.size();
  if (n > count) n = count;
  if (n > 0) std::memcpy(words, events.data(), n * sizeof(Event));
  return count;
}
