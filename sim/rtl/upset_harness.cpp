// SPDX-License-Identifier: Apache-2.0
// Single-event upsets in the Verilated ASIP: ticks as the driver runs them (sim/core/host/asip.c), one bit of a
// register or memory inverted after a clock edge, what came of it. Called by tests/upsets.
//
// The reference is the same model without an upset. Its whole state is saved at the start of every tick, so an
// injection costs the tick it is in and the ticks after, until nothing differs any more.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "Vasip.h"
#include "Vasip___024root.h"
#include "bench.h"
#include "verilated_syms.h"

void Vasip___024root___eval_settle(Vasip___024root*);  // of the model: wires follow a changed register

namespace {

// Of a register (one element) or memory.
struct Site {
  std::string name;
  uint32_t bits, elements, bytes;  // bytes of an element
  uint8_t* data;
};

struct Word {
  uint32_t address, data;
};

// Layout is that of the fields of tests/upsets/model.py.
struct Host {
  uint32_t status, control, start, clear, busy, done, fault, cause, cause_low, recovered;
  uint32_t check_again;  // STATUS is read after the outputs, too, and again where it reports no run
  uint32_t idle;         // clocks between ticks
  uint32_t most;         // clocks to wait for an answer or the end of a run
};

struct Upset {
  uint32_t tick, clock, site, element, bit;
};

enum Effect : uint32_t { Masked, Corrected, WrongOnce, WrongLater, Latent, Reported, Lost, LockedUp };

struct Outcome {  // also tests/upsets/model.py
  uint32_t effect;
  uint32_t cause;     // of the fault, 0 without one
  uint32_t ticks;     // from the upset on until the host knew or nothing differed
  uint32_t unsafe;    // outputs after a fault that were not the safe values
  double worst;       // largest error of an output, as a part of its limit
};

enum class End { Done, Fault, Nothing, Never };

struct Injector : Bench<Injector, Vasip> {
  std::vector<Site> sites;
  Host host{};
  std::vector<Word> load;
  std::vector<uint32_t> inputs, outputs, safe;  // addresses; safe values
  std::vector<float> limits;
  std::vector<uint32_t> words;                  // of the inputs, tick by tick
  std::vector<std::vector<uint32_t>> expected;  // outputs by tick
  std::vector<std::vector<uint8_t>> kept;       // whole state before each tick
  std::vector<uint32_t> lengths;                // clocks of each tick
  uint64_t begun = 0;                           // of the tick
  uint64_t at = ~0ull;                          // clock of the upset
  const Upset* upset = nullptr;
  uint32_t last_status = 0, corrected = 0;

  Injector() {
    top->read_i = top->write_i = 0;
    top->address_i = 0;
    top->writedata_i = 0;
    reset();
    find_sites();
  }

  void find_sites() {
    std::map<std::string, Site> found;
    for (const auto& scope : *context.scopeNameMap()) {
      if (!scope.second->varsp()) continue;
      for (const auto& each : *scope.second->varsp()) {
        const VerilatedVar& var = each.second;
        std::string own = var.name();
        if (own[0] == '\\') own = own.substr(1, own.find(' ') - 1);  // of a netlist, with its path
        const std::string name = std::string(scope.second->name()) + "." + own;
        if (var.isParam() || var.udims() > 1) continue;
        const uint32_t elements = var.udims() == 1 ? var.elements(1) : 1;
        found[name] = {name, var.entBits(), elements, uint32_t(var.totalSize() / elements),
                       static_cast<uint8_t*>(var.datap())};
      }
    }
    std::map<uint8_t*, bool> seen;  // a memory that several names share counts once
    for (auto& each : found) {
      if (!seen.emplace(each.second.data, true).second) continue;
      if (each.second.elements > 1 || keeps(each.second)) sites.push_back(each.second);
    }
  }

  // Whether a changed bit stays: a wire gets its value back at once. Some wires of stage Q end in _q.
  bool keeps(const Site& site) {
    const uint8_t was = *site.data;
    *site.data ^= 1;
    Vasip___024root___eval_settle(top->rootp);
    const bool kept = *site.data != was;
    *site.data = was;
    Vasip___024root___eval_settle(top->rootp);
    return kept;
  }

  void flip(const Upset& one) {
    Site& site = sites[one.site];
    site.data[size_t(one.element) * site.bytes + one.bit / 8] ^= uint8_t(1u << (one.bit % 8));
    Vasip___024root___eval_settle(top->rootp);
  }

  void edge() {
    rise();
    if (clocks == at) flip(*upset);
  }

  std::vector<uint8_t> state() const {
    const auto* bytes = reinterpret_cast<const uint8_t*>(top->rootp);
    return {bytes, bytes + sizeof(*top->rootp)};
  }

  void go_back(uint32_t tick) {
    std::memcpy(reinterpret_cast<void*>(top->rootp), kept[tick].data(), kept[tick].size());
  }

  bool same_as(uint32_t tick) const {
    const auto* base = reinterpret_cast<const uint8_t*>(top->rootp);
    for (const Site& site : sites) {
      const size_t offset = site.data - base;
      if (std::memcmp(site.data, kept[tick].data() + offset, size_t(site.bytes) * site.elements)) return false;
    }
    return true;
  }

  bool write(uint32_t address, uint32_t data) { return access(address, &data, true, host.most); }
  bool read(uint32_t address, uint32_t* data) { return access(address, data, false, host.most); }

  bool read_outputs(std::vector<uint32_t>& found) {
    found.resize(outputs.size());
    for (size_t i = 0; i < outputs.size(); ++i) {
      if (!read(outputs[i], &found[i])) return false;
    }
    return true;
  }

  // STATUS when it reports no run going on, as asip_wait reads it.
  bool wait(uint32_t& status) {
    const uint64_t limit = clocks + host.most;
    do {
      if (!read(host.status, &status) || clocks > limit) return false;
    } while (status & host.busy);
    return true;
  }

  // One tick as asip_tick or asip_checked_tick does it. Outputs are read after Done and Fault.
  End tick(uint32_t number, std::vector<uint32_t>& found) {
    begun = clocks;
    for (size_t i = 0; i < inputs.size(); ++i) {
      if (!write(inputs[i], words[number * inputs.size() + i])) return End::Never;
    }
    if (!write(host.control, host.start)) return End::Never;
    uint32_t status = 0;
    if (!wait(status)) return End::Never;
    if (host.check_again && !(status & (host.fault | host.done)) && !wait(status)) return End::Never;
    last_status = status;
    if (host.recovered && (status & host.recovered)) corrected = 1;
    if (!(status & (host.fault | host.done))) return End::Nothing;
    if (!read_outputs(found)) return End::Never;
    if (host.check_again && !(status & host.fault)) {
      if (!read(host.status, &status)) return End::Never;
      last_status = status;
      if ((status & host.fault) && !read_outputs(found)) return End::Never;
    }
    for (uint32_t i = 0; i < host.idle; ++i) clock();
    return status & host.fault ? End::Fault : End::Done;
  }

  bool load_all() {
    if (!write(host.control, host.clear)) return false;
    uint32_t status;
    if (!wait(status)) return false;  // a host repeats asip_load while it says ASIP_BUSY
    for (const Word& each : load) {
      if (!write(each.address, each.data)) return false;
    }
    return true;
  }

  // The reference. 0, or the number of the tick that failed, from 1.
  uint32_t reference(uint32_t ticks) {
    expected.assign(ticks, {});
    kept.clear();
    lengths.clear();
    if (!load_all()) return 1;
    for (uint32_t i = 0; i < ticks; ++i) {
      kept.push_back(state());
      if (tick(i, expected[i]) != End::Done) return i + 1;
      lengths.push_back(clocks - begun);
    }
    kept.push_back(state());
    return 0;
  }

  double error(const std::vector<uint32_t>& found, uint32_t number) const {
    double worst = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      if (found[i] == expected[number][i]) continue;
      float is, was;
      std::memcpy(&is, &found[i], 4);
      std::memcpy(&was, &expected[number][i], 4);
      const double off = std::isfinite(is) ? std::fabs(double(is) - was) / limits[i] : 1e9;
      worst = std::max(worst, std::max(off, 1e-12));  // a wrong bit is an error, however small
    }
    return worst;
  }

  // Clear, load, and the first ticks again: whether the core is whole without a reset.
  bool restored() {
    top->read_i = top->write_i = 0;
    if (!load_all()) return false;
    std::vector<uint32_t> found;
    for (uint32_t i = 0; i < 2; ++i) {
      if (tick(i, found) != End::Done || found != expected[i]) return false;
    }
    return true;
  }

  Outcome inject(const Upset& one, uint32_t later) {
    Outcome outcome{Masked, 0, 0, 0, 0};
    go_back(one.tick);
    top->read_i = top->write_i = 0;
    upset = &one;
    at = clocks + 1 + one.clock;
    corrected = 0;
    uint32_t wrong = 0;
    std::vector<uint32_t> found;
    for (uint32_t i = 0; i <= later; ++i) {
      const uint32_t number = one.tick + i;
      outcome.ticks = i;
      const End end = tick(number, found);
      at = ~0ull;
      if (end != End::Done) {
        if (end == End::Fault) {
          outcome.cause = (last_status & host.cause) >> host.cause_low;
          outcome.unsafe = found != safe;
        }
        outcome.effect = wrong ? (wrong > 1 ? WrongLater : WrongOnce) : end == End::Fault ? Reported : Lost;
        if (!restored()) outcome.effect = LockedUp;
        return outcome;
      }
      const double off = error(found, number);
      outcome.worst = std::max(outcome.worst, off);
      wrong += off > 0;
      if (same_as(number + 1)) {
        outcome.effect = wrong ? (wrong > 1 ? WrongLater : WrongOnce) : corrected ? Corrected : Masked;
        return outcome;
      }
    }
    outcome.effect = wrong ? (wrong > 1 ? WrongLater : WrongOnce) : Latent;
    return outcome;
  }
};

std::string listing;

}  // namespace

extern "C" {

void* upset_new() { return new Injector; }
void upset_free(void* handle) { delete static_cast<Injector*>(handle); }

// A line per site: name, bits of an element, elements.
const char* upset_sites(void* handle) {
  listing.clear();
  for (const Site& site : static_cast<Injector*>(handle)->sites) {
    listing += site.name + " " + std::to_string(site.bits) + " " + std::to_string(site.elements) + "\n";
  }
  return listing.c_str();
}

// What the host does; then the run without an upset. Returns 0, or the tick that failed, from 1. The clocks of each
// tick go to `lengths`.
uint32_t upset_reference(void* handle, const Host* host, const Word* load, uint32_t loads, const uint32_t* inputs,
                         uint32_t input_count, const uint32_t* words, uint32_t ticks, const uint32_t* outputs,
                         const uint32_t* safe, const float* limits, uint32_t output_count, uint32_t* lengths) {
  auto* injector = static_cast<Injector*>(handle);
  injector->host = *host;
  injector->load.assign(load, load + loads);
  injector->inputs.assign(inputs, inputs + input_count);
  injector->words.assign(words, words + size_t(ticks) * input_count);
  injector->outputs.assign(outputs, outputs + output_count);
  injector->safe.assign(safe, safe + output_count);
  injector->limits.assign(limits, limits + output_count);
  const uint32_t failed = injector->reference(ticks);
  std::copy(injector->lengths.begin(), injector->lengths.end(), lengths);
  return failed;
}

// A word of the core after the last tick of the reference.
uint32_t upset_read(void* handle, uint32_t address) {
  uint32_t word = 0;
  static_cast<Injector*>(handle)->read(address, &word);
  return word;
}

// So many injections, `later` further ticks watched after each.
void upset_inject(void* handle, const Upset* upsets, uint32_t count, uint32_t later, Outcome* outcomes) {
  auto* injector = static_cast<Injector*>(handle);
  for (uint32_t i = 0; i < count; ++i) outcomes[i] = injector->inject(upsets[i], later);
}

}  // extern "C"
