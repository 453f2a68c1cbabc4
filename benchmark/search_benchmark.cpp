// SPDX-License-Identifier: BSD-3-Clause
// Times of the exhaustive search in the map of a recording. The initial guess of each scan is its
// pose plus a random displacement within the window.

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <random>
#include <string>

#include "kestrel_slam/experiments/mapped_log.h"
#include "kestrel_slam/matching/correlative.h"

namespace kestrel {
namespace {

constexpr double kResolution_m = 0.03;  // as in the experiments of [Olson 2009]
constexpr double kMillisecondsPerSecond = 1e3;
constexpr double kP99 = 0.99;
constexpr std::uint64_t kSeed = 1;

/// Processor time of this thread, without the time of other processes, ms.
double processorTime_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The time of one search of `scan` from a random displacement within the window, ms.
double timeOf(const MappedLog& log, const MappedScan& scan, const SearchWindow& window,
              std::mt19937_64& random) {
  std::uniform_real_distribution<double> shift(-window.linear_m, window.linear_m);
  std::uniform_real_distribution<double> turn(-window.angular_rad, window.angular_rad);
  Pose2 center = scan.pose;
  center.x += shift(random);
  center.y += shift(random);
  center.yaw += turn(random);
  const double start = processorTime_s();
  const SearchResult found =
      searchWindow(log.map.surface(), scan.points, center, window, CorrelativeConfig());
  const double seconds = processorTime_s() - start;
  return found.score > 0.0 ? kMillisecondsPerSecond * seconds : 0.0;
}

void measure(const MappedLog& log, const char* name, const SearchWindow& window,
             std::size_t count) {
  std::mt19937_64 random(kSeed);
  std::vector<double> times;
  const std::size_t step = std::max<std::size_t>(1, log.scans.size() / count);
  double sum = 0.0;
  for (std::size_t i = 0; i < log.scans.size(); i += step) {
    times.push_back(timeOf(log, log.scans[i], window, random));
    sum += times.back();
  }
  std::sort(times.begin(), times.end());
  const auto n = static_cast<double>(times.size());
  std::printf("%s: %zu scans, mean %.2f ms, p50 %.2f ms, p99 %.2f ms\n", name, times.size(),
              sum / n, times[times.size() / 2], times[static_cast<std::size_t>(kP99 * n)]);
}

void run(const std::string& recording, std::size_t small, std::size_t large) {
  const MappedLog log = mapLog(recording, kResolution_m);
  measure(log, "±0.5 m ±20°", {0.5, 20.0 * kPi / 180.0}, small);
  if (large > 0) measure(log, "±4 m ±90°", {4.0, 0.5 * kPi}, large);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: %s RECORDING [SCANS_OF_THE_SMALL_WINDOW] [OF_THE_LARGE]\n",
                 argv[0]);
    return EXIT_FAILURE;
  }
  constexpr int kBase = 10;
  try {
    kestrel::run(argv[1], argc > 2 ? std::max(1UL, std::strtoul(argv[2], nullptr, kBase)) : 500,
                 argc > 3 ? std::strtoul(argv[3], nullptr, kBase) : 50);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "search_benchmark: %s\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
