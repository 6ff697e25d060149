// SPDX-License-Identifier: Apache-2.0
// A line of slave controllers with a C interface: frames in and out at the master's ports, the application's port of
// each, and a service that joins the master's ports to the file descriptors of TAP devices.
#include <poll.h>
#include <unistd.h>

#include <atomic>

#include "Vethercat_slave.h"
#include "capture.h"
#include "ring.h"

#define EXPORT extern "C" __attribute__((visibility("default")))

using Line = Ring<Vethercat_slave>;

// Simulated, without a frame from the master: while one is on its way, which may be lost, and after all of them.
constexpr unsigned LOST_US = 300, IDLE_US = 50;

namespace {

// An access of the application, and what is to happen with its data.
struct Access {
  bool write;
  uint16_t address;
  uint8_t enable;
  uint32_t data;
  std::function<void(uint32_t)> then;
};

// Works off accesses at a slave's Avalon port, one at a time.
class Application {
 public:
  std::deque<Access> queue;
  // Process data to copy: from, bytes, to, bytes; 0 bytes: nothing.
  uint16_t outputs = 0, output_bytes = 0, inputs = 0, input_bytes = 0;

  void before_edge(Line::Slave& slave) {
    auto* top = slave.top.get();
    if (active_) {
      if (!top->avs_waitrequest_o) {
        const Access done = queue.front();
        queue.pop_front();
        const uint32_t data = top->avs_readdata_o;
        finishing_ = true;
        active_ = false;
        if (done.then) done.then(data);
        return;
      }
      return;
    }
    if (finishing_) {
      finishing_ = false;
      top->avs_read_i = top->avs_write_i = 0;
      top->eval();
      return;
    }
    if (queue.empty() && output_bytes && top->irq_o) copy();
    if (queue.empty()) return;
    const Access& next = queue.front();
    top->avs_address_i = next.address / 4;
    top->avs_read_i = !next.write;
    top->avs_write_i = next.write;
    top->avs_byteenable_i = next.enable;
    top->avs_writedata_i = next.data;
    top->eval();
    active_ = true;
  }

 private:
  static uint8_t enable(int left) { return left >= 4 ? 0xF : (1 << left) - 1; }

  // The outputs go back as inputs, with zeros after them: a loop that a master can see.
  void copy() {
    words_.assign((input_bytes + 3) / 4, 0);
    for (unsigned at = 0; at < output_bytes; at += 4) {
      queue.push_back({false, uint16_t(outputs + at), enable(output_bytes - at), 0, [this, at](uint32_t data) {
                         if (at / 4 < words_.size()) words_[at / 4] = data;
                         if (at + 4u >= output_bytes) answer();
                       }});
    }
  }

  void answer() {
    for (unsigned at = 0; at < input_bytes; at += 4) {
      queue.push_back({true, uint16_t(inputs + at), enable(input_bytes - at), words_[at / 4], nullptr});
    }
  }

  bool active_ = false, finishing_ = false;
  std::vector<uint32_t> words_;
};

struct Bus {
  Line line;
  std::vector<std::unique_ptr<Application>> applications;
  std::atomic<bool> stop{false};
  uint64_t sent = 0, returned = 0;
  Capture capture;
  // From another thread while bus_serve runs: cables that are to be pulled, and how many of the master's next frames
  // are to be lost before the slaves, damaged there, or lost on their way back.
  std::atomic<uint32_t> pulled{0};
  std::atomic<unsigned> disturbed[3] = {};

  bool disturb(int kind) {
    if (!disturbed[kind]) return false;
    --disturbed[kind];
    return true;
  }

  Bus(const std::vector<double>& ppm, uint64_t cable, bool closed) : line(ppm, cable, closed) {
    for (auto& slave : line.slaves) {
      applications.push_back(std::make_unique<Application>());
      Application* application = applications.back().get();
      slave->top->avs_read_i = slave->top->avs_write_i = 0;
      slave->application = [application](Line::Slave& s) { application->before_edge(s); };
    }
  }
};

}  // namespace

EXPORT Bus* bus_new(unsigned n, const double* ppm, uint64_t cable_ps, int closed) {
  return new Bus(std::vector<double>(ppm, ppm + n), cable_ps, closed);
}
EXPORT void bus_delete(Bus* bus) { delete bus; }
EXPORT void bus_run(Bus* bus, uint64_t ns) { bus->line.run(ns * 1000); }
EXPORT uint64_t bus_now(Bus* bus) { return bus->line.now; }
EXPORT void bus_cable(Bus* bus, unsigned i, int plugged) { bus->line.cable(i, plugged); }

EXPORT void bus_length(Bus* bus, unsigned i, uint64_t ps) { bus->line.length(i, ps); }
EXPORT void bus_pull(Bus* bus, uint32_t cables) { bus->pulled = cables; }
EXPORT void bus_disturb(Bus* bus, int kind, unsigned frames) { bus->disturbed[kind] = frames; }
EXPORT unsigned bus_disturbed(Bus* bus, int kind) { return bus->disturbed[kind]; }
EXPORT uint64_t bus_arrived(Bus* bus, unsigned i) { return bus->line.slaves.at(i)->arrived; }

// A frame of nibbles from the start delimiter on, `gap` nibbles after the last.
EXPORT void bus_send(Bus* bus, int port, const uint8_t* nibbles, unsigned n, int error_at, unsigned gap) {
  bus->line.send[port].send(std::vector<uint8_t>(nibbles, nibbles + n), error_at, gap);
}

// The oldest frame that came back; -1: none. times: of its first nibble and its end, in ps.
EXPORT int bus_receive(Bus* bus, int port, uint8_t* nibbles, unsigned most, uint64_t* times) {
  auto& frames = bus->line.received[port].frames;
  if (frames.empty()) return -1;
  const Frame& frame = frames.front();
  const unsigned n = frame.nibbles.size();
  std::memcpy(nibbles, frame.nibbles.data(), n < most ? n : most);
  times[0] = frame.began;
  times[1] = frame.ended;
  frames.pop_front();
  return n;
}

// A write of the application of slave i, after those ordered before; the line does not run.
EXPORT void bus_order(Bus* bus, unsigned i, uint16_t address, uint8_t enable, uint32_t data) {
  bus->applications.at(i)->queue.push_back({true, address, enable, data, nullptr});
}

// Access of the application of slave i; runs the line until it is done, 0 if that takes 1 ms.
EXPORT int bus_access(Bus* bus, unsigned i, int write, uint16_t address, uint8_t enable, uint32_t* data) {
  bool done = false;
  bus->applications.at(i)->queue.push_back({bool(write), address, enable, *data, [&](uint32_t read) {
                                              *data = read;
                                              done = true;
                                            }});
  for (int n = 0; n < 10000 && !done; ++n) bus->line.run(100000);
  return done;
}

// From now on the outputs of slave i are copied to its inputs whenever its interrupt is there.
EXPORT void bus_copy(Bus* bus, unsigned i, uint16_t outputs, uint16_t output_bytes, uint16_t inputs,
                     uint16_t input_bytes) {
  Application& application = *bus->applications.at(i);
  application.outputs = outputs;
  application.output_bytes = output_bytes;
  application.inputs = inputs;
  application.input_bytes = input_bytes;
}

EXPORT uint64_t bus_time(Bus* bus, unsigned i) { return bus->line.slaves.at(i)->top->time_o; }
EXPORT unsigned bus_sync(Bus* bus, unsigned i) { return bus->line.slaves.at(i)->top->sync_o; }
EXPORT void bus_latch(Bus* bus, unsigned i, unsigned levels) { bus->line.slaves.at(i)->top->latch_i = levels; }
EXPORT int bus_in_reset(Bus* bus, unsigned i) { return !bus->line.slaves.at(i)->top->reset_no; }
EXPORT uint64_t bus_clocks(Bus* bus, unsigned i) { return bus->line.slaves.at(i)->clocks; }

// A pcap file of what passes the master's first port in bus_serve; 0 if it cannot be written.
EXPORT int bus_capture(Bus* bus, const char* path) { return bus->capture.open(path); }

EXPORT void bus_stop(Bus* bus) { bus->stop = true; }
EXPORT void bus_restart(Bus* bus) { bus->stop = false; }
EXPORT uint64_t bus_count(Bus* bus, int which) { return which ? bus->returned : bus->sent; }

// Joins the master's ports to TAP devices that do not block, until bus_stop; a second one of -1: the first port only.
// What the master sends goes to the line at once, what comes back whole and with a good check sequence goes to the
// master. After IDLE_US time goes on by 1 us in 1 ms, so that waiting for a master that computes costs nothing.
EXPORT void bus_serve(Bus* bus, int first, int second) {
  uint8_t bytes[2048];
  unsigned idle = 0, on_their_way = 0;
  uint32_t pulled = 0;
  pollfd fds[2] = {{first, POLLIN, 0}, {second, POLLIN, 0}};
  const int ports = second < 0 ? 1 : 2;
  while (!bus->stop) {
    if (++idle > (on_their_way ? LOST_US : IDLE_US)) {
      on_their_way = 0;
      if (poll(fds, ports, 1) > 0) idle = 0;
    }
    if (const uint32_t wanted = bus->pulled; wanted != pulled) {
      for (unsigned i = 0; i <= bus->line.slaves.size(); ++i) {
        if ((wanted ^ pulled) >> i & 1) bus->line.cable(i, !(wanted >> i & 1));
      }
      pulled = wanted;
    }
    for (int port = 0; port < ports; ++port) {
      ssize_t n;
      while ((n = read(fds[port].fd, bytes, 1600)) > 0) {
        while (n < 60) bytes[n++] = 0;
        if (port == 0) bus->capture.record(bytes, n, bus->line.now);
        idle = 0;
        if (bus->disturb(0)) continue;
        auto nibbles = nibbles_of(bytes, n);
        if (bus->disturb(1)) nibbles[nibbles.size() / 2] ^= 1;
        bus->line.send[port].send(nibbles, -1, GAP_NIBBLES);
        ++bus->sent;
        ++on_their_way;
      }
    }
    bus->line.run(1000000);
    for (int port = 0; port < ports; ++port) {
      auto& frames = bus->line.received[port].frames;
      for (; !frames.empty(); frames.pop_front()) {
        if (on_their_way) --on_their_way;
        idle = 0;
        const auto back = bytes_of(frames.front());
        if (back.empty() || bus->disturb(2)) continue;
        if (port == 0) bus->capture.record(back.data(), back.size(), frames.front().ended);
        if (write(fds[port].fd, back.data(), back.size()) > 0) ++bus->returned;
      }
    }
  }
}
