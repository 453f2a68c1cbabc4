// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {

/// What the report shows of a state of the pose filter.
inline std::optional<FilterSample> sampleOf(const std::optional<FilterOutput>& state) {
  if (!state) return std::nullopt;
  const FilterOutput& output = *state;
  const double up = output.map_T_base.linear()(2, 2);
  return FilterSample{output.height(), std::acos(std::clamp(up, -1.0, 1.0)),
                      output.gyro_bias.norm(), output.accelerometer_bias.norm()};
}

/// The same of the tracker beside the mapper; null: it does not run.
inline std::optional<TrackerSample> sampleOf(const MovingBeams* moving) {
  if (moving == nullptr) return std::nullopt;
  const Tracker::Result& result = moving->result();
  const auto objects = std::count_if(result.tracks.begin(), result.tracks.end(),
                                     [](const Track& track) { return track.isShown(); });
  const auto beams = std::count(result.is_moving.begin(), result.is_moving.end(), true);
  const auto all = static_cast<double>(std::max<std::size_t>(result.is_moving.size(), 1));
  return TrackerSample{static_cast<double>(objects), static_cast<double>(beams) / all};
}

}  // namespace kestrel
