// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/experiments/merging_measurement.h"

namespace kestrel {

/// When two vehicles that fly at the same time have seen the same, and when they are joined. Times
/// are since both have begun.
struct JoiningTime {
  std::size_t a = 0, b = 0;  ///< vehicles
  /// When a scan of one was known in the map of the other, and fitted, for the first time. Where
  /// the maps lie is known from their end for this. Nothing: not until the end.
  std::optional<double> seen_s;
  std::optional<double> joined_s;
  double off_m = 0.0;  ///< of the last keyframe of b then, from where it is by the maps of the end

  std::optional<double> later() const {
    return seen_s && joined_s ? std::optional<double>(*joined_s - *seen_s) : std::nullopt;
  }
};

/// Merges the maps while they grow, every so many seconds, until all vehicles are joined with each
/// other or the flight ends.
std::vector<JoiningTime> measureJoining(const std::vector<MappedVehicle>& vehicles,
                                        const SlamConfig& config, double every_s);

}  // namespace kestrel
