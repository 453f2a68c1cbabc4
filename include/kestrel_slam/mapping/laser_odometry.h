// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/mapping/prediction_error.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

class Mapper;

/// A scan and its pose.
struct PlacedScan {
  PlanarScan scan;
  Pose2 map_T_base;
  PredictionError error;  ///< of the pose, since the last match with the map
};

/// The motion of the vehicle from scans alone, for scans that do not fit the map: each is matched
/// with the scans before it, in a map of their own.
class LaserOdometry {
 public:
  explicit LaserOdometry(const MapperConfig& config);
  ~LaserOdometry();
  LaserOdometry(LaserOdometry&&) noexcept;
  LaserOdometry& operator=(LaserOdometry&&) noexcept;

  /// The motion is measured from this scan on.
  void begin(const PlanarScan& scan, const Pose2& map_T_base, const PredictionError& error);

  /// Forgets all scans, for example because the last one shows nothing.
  void stop();

  /// Matches a scan with those since begin(). Returns false if it does not fit them.
  bool follow(const PlanarScan& scan);

  /// Whether the last scan was matched with the scans before it.
  bool isFollowing() const { return following_; }

  /// map_T_base of the last scan, or its prediction if it was not matched.
  const Pose2& pose() const { return pose_; }
  /// Of `pose()`: the error at begin() and that of the motion since then.
  const PredictionError& error() const { return error_; }
  /// Number of scans that were matched since begin().
  int steps() const { return steps_; }
  /// The scans since begin(), without those that were taken at the same place. Old ones are
  /// dropped.
  const std::vector<PlacedScan>& scans() const { return scans_; }

 private:
  void restart();

  MapperConfig config_;
  std::unique_ptr<Mapper> mapper_;  ///< of the scans since begin(); created when it is needed
  std::vector<PlacedScan> scans_;   ///< the first one is that of begin()
  Pose2 first_pose_;
  PredictionError first_error_;
  Pose2 pose_;
  PredictionError error_;
  int steps_ = 0;
  bool following_ = false;
};

}  // namespace kestrel
