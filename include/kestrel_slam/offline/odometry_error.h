// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {

/// Errors that are added to the odometry of a recording.
struct OdometryError {
  double short_share = 0.0;       ///< 0.1: every distance is 10 % too short
  double turn_rad_per_m = 0.0;    ///< a turn that the vehicle did not make, per meter of its path
  bool is_unsigned = false;       ///< driving backward is counted as driving forward
  double slip_m = 0.0;            ///< length of a slip, in a random direction
  double meters_per_slip = 30.0;  ///< mean distance between two slips
  std::uint64_t seed = 1;         ///< of places and directions of the slips
};

/// Reads a list of errors with commas between them, such as
/// "short:0.1,turn:0.02,unsigned,slip:0.5". Throws std::invalid_argument with the item that is
/// wrong.
OdometryError parseOdometryError(const std::string& text);

/// Adds errors to odometry, pose by pose.
class OdometryDistortion {
 public:
  explicit OdometryDistortion(const OdometryError& error) : error_(error), random_(error.seed) {}

  /// The next pose of the odometry, with the errors since the first pose. Without errors, the pose
  /// itself.
  Pose2 next(const Pose2& odom_T_base);

 private:
  Pose2 distorted(const Pose2& motion);

  OdometryError error_;
  Random random_;
  std::optional<Pose2> last_;  ///< without errors
  Pose2 result_;               ///< with errors
};

}  // namespace kestrel
