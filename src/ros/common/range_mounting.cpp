// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/range_mounting.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/ros/common/names.h"

namespace kestrel {
namespace {

constexpr double kMinCosine = 0.94;  // within 20 degrees of straight down, as offline

std::optional<double> numberOf(const std::string& text) {
  if (text.empty()) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (*end == '\0' && std::isfinite(value)) return value;
  throw std::invalid_argument("height_sensor_z = " + text +
                              ": must be empty or a number: the height of the range finder in the "
                              "base frame, m");
}

}  // namespace

RangeMounting::RangeMounting(const Mountings& mountings, const std::string& parameter)
    : mountings_(mountings), fixed_z_(numberOf(parameter)) {}

std::optional<double> RangeMounting::sensorZ(const std::string& frame) {
  error_.clear();
  if (fixed_z_) return fixed_z_;
  if (frame == mountings_.baseFrame()) return 0.0;  // at the origin of the base, and looks down
  const std::optional<Eigen::Isometry3d> base_T_sensor = mountings_.lookup(frame);
  if (!base_T_sensor) {
    error_ = "tf has no mounting of the range finder '" + clippedName(frame) +
             "': it is not used. Publish its transform, or set ~height_sensor_z";
    return std::nullopt;
  }
  const double cosine = std::clamp(-base_T_sensor->linear()(2, 0), -1.0, 1.0);
  if (cosine >= kMinCosine) return base_T_sensor->translation().z();
  error_ = "the range finder '" + clippedName(frame) +
           "' does not look down: its x axis in tf is " +
           std::to_string(std::lround(radToDeg(std::acos(cosine)))) +
           " degrees off. Correct tf, or set ~height_sensor_z";
  return std::nullopt;
}

}  // namespace kestrel
