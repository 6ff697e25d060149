// SPDX-License-Identifier: Apache-2.0
// The device on the bus (ethercat_nios) with a C interface: program, control ticks and an ideal machine, frames in and
// out at port 0, and a service that joins that port to the file descriptor of a TAP device.
//
// The machine, unless the caller plays it: each axis with power is where its set-point of the tick before was; digital
// inputs are the inverted digital outputs. Words of a tick: nios_sw/ethercat/ethercat_tick.h.
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <string>

#include "Vethercat_nios.h"
#include "capture.h"
#include "ring.h"

#define EXPORT extern "C" __attribute__((visibility("default")))

using Line = Ring<Vethercat_nios>;

namespace {

constexpr unsigned AXES = 5;
constexpr unsigned INPUTS = 4 * AXES + 3, OUTPUTS = 5 * AXES + 4;
constexpr unsigned POSITION = 0, TORQUE_FLAGS = 4 * AXES, DIGITAL_OUTPUTS = 5 * AXES;
constexpr uint32_t POWER = 0x10000, TORQUE_ONLY = 0x20000;

struct Device {
  Line line{{0.0}, 25000, false};
  uint32_t input_base = 0, output_base = 0, tick_clocks = 0;
  uint32_t inputs[INPUTS] = {}, outputs[OUTPUTS] = {};
  uint32_t since = 0, at = 0;
  enum { IDLE, WRITING, WAITING, READING } state = IDLE;
  uint32_t last_cycles = 0, longest = 0;
  uint64_t ticks = 0, sum = 0;
  bool overrun = false, ideal = true, due = false, sync = false;
  std::vector<uint64_t> syncs, dues;  // clocks in which SYNC0 began, a control tick was due
  Capture capture;
  std::string console;
  std::atomic<bool> stop{false};
  uint64_t sent = 0, returned = 0, late = 0;

  Device() {
    auto* top = line.slaves[0]->top.get();
    top->run_i = 0;
    top->host_write_i = top->tick_i = 0;
    top->host_address_i = top->host_wdata_i = 0;
    line.slaves[0]->application = [this](Line::Slave& slave) { before_edge(slave.top.get()); };
  }

  // One access of the host a clock: the inputs before a tick, the outputs after it.
  void before_edge(Vethercat_nios* top) {
    if (top->console_valid_o) console.push_back(char(top->console_data_o));
    top->host_write_i = 0;
    if (top->tick_i) {
      top->tick_i = 0;
      top->eval();
    }
    if (!tick_clocks) return;
    ++since;
    if (top->sync_o & 1 && !sync) syncs.push_back(line.slaves[0]->clocks);
    sync = top->sync_o & 1;
    if (top->due_o) {
      since = 0;
      late += due || state != IDLE;
      due = true;
      dues.push_back(line.slaves[0]->clocks);
    }
    if (due && state == IDLE) {
      due = false;
      at = 0;
      state = WRITING;
    }
    if (state == WRITING) {
      if (at < INPUTS) {
        top->host_address_i = input_base + 4 * at;
        top->host_wdata_i = inputs[at++];
        top->host_write_i = 1;
      } else {
        top->tick_i = 1;
        top->eval();  // before the edge, where assertions sample it
        at = 0;
        state = WAITING;
      }
    } else if (state == WAITING) {
      if (at++ > 3 && !top->pending_o) {
        last_cycles = top->tick_cycles_o;
        if (last_cycles > longest) longest = last_cycles;
        sum += last_cycles;
        ++ticks;
        overrun |= top->overrun_o;
        at = 0;
        state = READING;
        top->host_address_i = output_base;
      }
    } else if (state == READING) {
      // Data of an address come with the next clock.
      if (at > 0) outputs[at - 1] = top->host_rdata_o;
      if (at == OUTPUTS) {
        if (ideal) move();
        state = IDLE;
      } else {
        top->host_address_i = output_base + 4 * at;
      }
      ++at;
    }
  }

  // A frame from the master onto the wire.
  void send(const uint8_t* frame, size_t n) {
    capture.record(frame, n, line.now);
    line.send[0].send(nibbles_of(frame, n), -1, GAP_NIBBLES);
    ++sent;
  }

  // What has come back goes to the master; a frame whose check sequence is wrong does not reach it.
  void give(int fd) {
    auto& frames = line.received[0].frames;
    for (; !frames.empty(); frames.pop_front()) {
      const auto back = bytes_of(frames.front());
      if (back.empty()) continue;
      capture.record(back.data(), back.size(), frames.front().ended);
      if (write(fd, back.data(), back.size()) > 0) ++returned;
    }
  }

  void move() {
    for (unsigned n = 0; n < AXES; ++n) {
      const uint32_t flags = outputs[TORQUE_FLAGS + n];
      if ((flags & POWER) && !(flags & TORQUE_ONLY)) inputs[n] = outputs[POSITION + n];
      inputs[AXES + n] = (inputs[AXES + n] & 0xFFFF0000u) | (flags & 0xFFFFu);
    }
    inputs[3 * AXES] = ~outputs[DIGITAL_OUTPUTS] & 0xFFu;
  }
};

}  // namespace

EXPORT Device* device_new() { return new Device; }
EXPORT void device_delete(Device* device) { delete device; }
EXPORT void device_run(Device* device, uint64_t ns) { device->line.run(ns * 1000); }
EXPORT uint64_t device_time(Device* device) { return device->line.slaves[0]->top->time_o; }

// Clocks so far in which SYNC0 began (0), or a control tick was due (1): the last `most` of them; how many there are.
EXPORT uint64_t device_clocks(Device* device, int which, uint64_t* clocks, uint64_t most) {
  const auto& all = which ? device->dues : device->syncs;
  const size_t count = std::min<size_t>(all.size(), most);
  std::copy(all.end() - count, all.end(), clocks);
  return count;
}
EXPORT uint64_t device_now(Device* device) { return device->line.now; }

// Words into a memory of the core while it is held in reset.
EXPORT void device_load(Device* device, uint32_t address, const uint32_t* words, uint32_t count) {
  auto& slave = *device->line.slaves[0];
  for (uint32_t i = 0; i < count; ++i) {
    slave.top->host_address_i = address + 4 * i;
    slave.top->host_wdata_i = words[i];
    slave.top->host_write_i = 1;
    slave.clock();
  }
  slave.top->host_write_i = 0;
}

// The core runs; a tick when it is due, each `clocks` without SYNC0, its words at these addresses.
EXPORT void device_start(Device* device, uint32_t input_base, uint32_t output_base, uint32_t clocks) {
  device->line.slaves[0]->top->run_i = 1;
  device->input_base = input_base;
  device->output_base = output_base;
  device->tick_clocks = clocks;
}

// 0 ticks, 1 cycles of the last, 2 of the longest, 3 of all, 4 overrun, 5 frames sent, 6 returned, 7 ticks that were due
// before the one before was served.
EXPORT uint64_t device_count(Device* device, int which) {
  const uint64_t counts[] = {device->ticks,   device->last_cycles, device->longest, device->sum,
                             device->overrun, device->sent,        device->returned, device->late};
  return counts[which];
}

EXPORT void device_restart_counts(Device* device) { device->longest = device->ticks = device->sum = device->late = 0; }
EXPORT uint32_t* device_outputs(Device* device) { return device->outputs; }
EXPORT uint32_t* device_inputs(Device* device) { return device->inputs; }
EXPORT const char* device_console(Device* device) { return device->console.c_str(); }
EXPORT void device_stop(Device* device) { device->stop = true; }
EXPORT void device_restart(Device* device) { device->stop = false; }
EXPORT int device_capture(Device* device, const char* path) { return device->capture.open(path); }

// From now on the caller plays the machine: nothing but it changes the inputs.
EXPORT void device_take_machine(Device* device) { device->ideal = false; }

// Runs until `clocks` before the next control tick begins.
EXPORT void device_align(Device* device, uint32_t clocks) {
  while (device->since != device->tick_clocks - clocks || device->state != Device::IDLE) device->line.run(CLOCK_PS);
}

// A frame without check sequence, of 1600 bytes at most; what came back before is counted.
EXPORT void device_send(Device* device, const uint8_t* frame, uint32_t n) {
  device->send(frame, n);
  auto& frames = device->line.received[0].frames;
  for (; !frames.empty(); frames.pop_front()) device->returned += !bytes_of(frames.front()).empty();
}

// The next frame that has come back with a right check sequence, which is left out; its bytes, 0: there is none.
EXPORT uint32_t device_receive(Device* device, uint8_t* room, uint32_t bytes) {
  auto& frames = device->line.received[0].frames;
  for (; !frames.empty(); frames.pop_front()) {
    const auto back = bytes_of(frames.front());
    if (back.empty() || back.size() > bytes) continue;
    std::copy(back.begin(), back.end(), room);
    ++device->returned;
    frames.pop_front();
    return uint32_t(back.size());
  }
  return 0;
}

// Puts the frames that wait at `fd`, a TAP device that does not block, onto the wire; waits for the first one, at most
// `most_ms`. Returns how many there were.
EXPORT int device_take(Device* device, int fd, int most_ms) {
  uint8_t bytes[2048];
  pollfd wait = {fd, POLLIN, 0};
  int count = 0;
  poll(&wait, 1, most_ms);
  for (ssize_t n; (n = read(fd, bytes, 1600)) > 0; ++count) device->send(bytes, n);
  return count;
}

EXPORT void device_give(Device* device, int fd) { device->give(fd); }

// Joins port 0 to such an `fd` until device_stop; time goes on without frames too.
EXPORT void device_serve(Device* device, int fd) {
  while (!device->stop) {
    device_take(device, fd, 0);
    device->line.run(1000000);
    device->give(fd);
  }
}
