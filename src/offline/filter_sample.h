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

}  // namespace kestrel
