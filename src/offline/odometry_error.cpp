// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/odometry_error.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

void parseItem(const std::string& item, OdometryError& error) {
  const std::size_t colon = item.find(':');
  const std::string name = item.substr(0, colon);
  double value = 0.0;
  const bool has_value = colon != std::string::npos && parseFinite(item.substr(colon + 1), value);
  if (item == "unsigned") {
    error.is_unsigned = true;
  } else if (name == "short" && has_value) {
    error.short_share = value;
  } else if (name == "turn" && has_value) {
    error.turn_rad_per_m = value;
  } else if (name == "slip" && has_value) {
    error.slip_m = value;
  } else {
    throw std::invalid_argument("'" + item +
                                "' is no odometry error; use short:SHARE, turn:RAD_PER_M, unsigned "
                                "or slip:M, with commas between them");
  }
}

}  // namespace

OdometryError parseOdometryError(const std::string& text) {
  OdometryError error;
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) parseItem(item, error);
  return error;
}

Pose2 OdometryDistortion::next(const Pose2& odom_T_base) {
  result_ = last_ ? result_ * distorted(last_->between(odom_T_base)) : odom_T_base;
  last_ = odom_T_base;
  return result_;
}

Pose2 OdometryDistortion::distorted(const Pose2& motion) {
  const double scale = 1.0 - error_.short_share, distance = motion.distance();
  const double forward = error_.is_unsigned ? std::abs(motion.x) : motion.x;
  Pose2 result(scale * forward, scale * motion.y, motion.yaw + error_.turn_rad_per_m * distance);
  if (error_.slip_m > 0.0 && random_.uniform() * error_.meters_per_slip < distance) {
    const double direction = random_.uniform(-kPi, kPi);
    result.x += error_.slip_m * std::cos(direction);
    result.y += error_.slip_m * std::sin(direction);
  }
  return result;
}

}  // namespace kestrel
