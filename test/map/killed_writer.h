// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <random>
#include <thread>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// Two maps that differ in everything that the YAML file holds: a mixture of them is found.
inline MapSnapshot oneOfTwoMaps(bool second) {
  MapSnapshot map;
  map.resolution_m = second ? 0.1 : 0.05;
  map.origin_x = second ? -20.0 : -10.0;
  map.origin_y = second ? -5.0 : -7.0;
  map.width = second ? 300 : 400;
  map.height = second ? 200 : 100;
  map.cells.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height),
                   second ? MapSnapshot::kFree : MapSnapshot::kOccupied);
  return map;
}

inline bool equal(const MapSnapshot& a, const MapSnapshot& b) {
  return a.resolution_m == b.resolution_m && a.origin_x == b.origin_x && a.origin_y == b.origin_y &&
         a.width == b.width && a.height == b.height && a.cells == b.cells;
}

/// Runs `write(n)` for n = 0, 1, ... in a child process and kills it at a random time, `kills`
/// times. Calls `check` after each.
inline void killWhileWriting(int kills, const std::function<void(int)>& write,
                             const std::function<void()>& check) {
  std::mt19937 random(12);
  std::uniform_int_distribution<int> delay_us(0, 20000);
  for (int i = 0; i < kills && !::testing::Test::HasFailure(); ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (int n = 0;; ++n) write(n);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(delay_us(random)));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    check();
  }
}

}  // namespace kestrel
