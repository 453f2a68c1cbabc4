// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace kestrel {

constexpr double kKilobytesPerMegabyte = 1024.0;

/// Uses VmHWM, because getrusage may report the peak memory of the parent process.
inline double peakMemoryMb() {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    double kilobytes = 0.0;
    if (key == "VmHWM:" && status >> kilobytes) return kilobytes / kKilobytesPerMegabyte;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / kKilobytesPerMegabyte;
}

}  // namespace kestrel
