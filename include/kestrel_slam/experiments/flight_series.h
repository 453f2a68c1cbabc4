// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kestrel_slam/experiments/flight_measurement.h"
#include "kestrel_slam/experiments/loop_quality.h"

namespace kestrel {

/// The same flight or drive with different seeds: one seed is no result.
struct FlightSeries {
  std::string name;
  std::function<FlightTrial(std::uint64_t)> trial;  ///< the trial with a seed
};

/// The standard flights, random flights, drives with fast turns and drives through towns.
std::vector<FlightSeries> flightSeries();

/// A ground vehicle with a SICK laser (180 beams, 180°, 5 Hz) and no other sensor. It stops every
/// few meters and turns by 60° to 180° at a rate of 60 to 300°/s, so that there are up to 60°
/// between two scans. The building is one of three; it depends on the seed, as do path and rate.
FlightTrial fastTurnDrive(std::uint64_t seed);

/// The figures of one flight for comparisons over many seeds.
struct SeedResult {
  std::uint64_t seed = 0;
  std::size_t scans = 0, lost = 0, degraded = 0;
  double ate_m = 0.0;    ///< rmse of all scans, after the best rigid alignment
  double worst_m = 0.0;  ///< largest error of a scan, likewise
  /// Jumps above kSilentJump: differences of the motions between two scans, estimated and true,
  /// where neither scan is called degraded or lost.
  std::size_t silent_jumps = 0;
  double largest_silent_jump_m = 0.0;
  /// Scans in the state ok with an error above kWrongPose or kWrongYaw. The first scan defines the
  /// map.
  std::size_t wrong_and_ok = 0;
  std::size_t first_wrong = 0;  ///< index of the first of them
  /// Largest errors along the long axis of the covariance ellipse, and along the short one.
  double worst_long_m = 0.0, worst_long_sigmas = 0.0, worst_short_m = 0.0;
  double first_quarter_ms = 0.0, last_quarter_ms = 0.0;  ///< measured time per scan, median
  double area_m2 = 0.0;                                  ///< of the known cells
  LoopQuality loops;                                     ///< with a pose graph
};

constexpr double kSilentJump = 0.03;  ///< m
constexpr double kWrongPose = 0.2;    ///< m
constexpr double kWrongYawDeg = 5.0;

SeedResult resultOf(const FlightMeasurement& flight);

}  // namespace kestrel
