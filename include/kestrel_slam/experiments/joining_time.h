// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "kestrel_slam/experiments/merging_measurement.h"

namespace kestrel {

/// When two vehicles that fly at the same time have seen the same place, and when they are joined.
struct JoiningTime {
  std::size_t a = 0, b = 0;      ///< vehicles
  std::optional<double> seen_s;  ///< since both have begun; nothing: not until the end
  std::optional<double> joined_s;
  double off_m = 0.0;  ///< of the last keyframe of b then, from where it is by the maps of the end

  std::optional<double> later() const {
    return seen_s && joined_s ? std::optional<double>(*joined_s - *seen_s) : std::nullopt;
  }
};

/// The first time at which both vehicles have been where they see the same: a keyframe of one that
/// fits into the map of the other is within 3 m of a keyframe that the other has flown until then.
/// `whole`: the result for the maps of the end. All vehicles begin at the same time.
std::vector<JoiningTime> commonViews(const std::vector<MappedVehicle>& vehicles,
                                     const MergeResult& whole);

/// Merges the maps while they grow, every so many seconds, until all vehicles are joined with each
/// other or the flight ends. `show` is called after every merge.
std::vector<JoiningTime> measureJoining(
    const std::vector<MappedVehicle>& vehicles, const SlamConfig& config, double every_s,
    const std::function<void(double, const MergeResult&)>& show = {});

}  // namespace kestrel
