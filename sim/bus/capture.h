// SPDX-License-Identifier: Apache-2.0
// A pcap file of Ethernet frames, with times in nanoseconds, as Wireshark reads it.
#pragma once
#include <cstdint>
#include <cstdio>

class Capture {
 public:
  ~Capture() {
    if (file_) std::fclose(file_);
  }

  // Begins the file; false if it cannot be written.
  bool open(const char* path) {
    file_ = std::fopen(path, "wb");
    if (!file_) return false;
    const uint32_t magic_ns = 0xA1B23C4D;
    const uint16_t version[2] = {2, 4};
    const uint32_t rest[4] = {0, 0, 65535, 1};
    std::fwrite(&magic_ns, 4, 1, file_);
    std::fwrite(version, 4, 1, file_);
    std::fwrite(rest, sizeof rest, 1, file_);
    return true;
  }

  // A frame without check sequence; nothing without a file.
  void record(const uint8_t* bytes, uint32_t n, uint64_t time_ps) {
    if (!file_) return;
    const uint32_t head[4] = {uint32_t(time_ps / 1000000000000ull), uint32_t(time_ps / 1000 % 1000000000ull), n, n};
    std::fwrite(head, sizeof head, 1, file_);
    std::fwrite(bytes, n, 1, file_);
  }

 private:
  std::FILE* file_ = nullptr;
};
