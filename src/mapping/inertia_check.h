// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "kestrel_slam/mapping/motion_model.h"

namespace kestrel {

/// Compares the matches with the motion by the IMU alone since a match last agreed with it.
///
/// What a tilted laser sees of the floor, or of things that are not as high as the walls, may take
/// the pose along for some scans, by more than the IMU explains.
class InertiaCheck {
 public:
  /// From `matched` to where the IMU says that the vehicle is, in the map frame, m. Nothing if both
  /// agree, or if there is no IMU.
  std::optional<Eigen::Vector2d> contradiction(const PlanarScan& scan, const Pose2& matched) const;

  /// Learns how well the IMU predicts a scan on this vehicle. `motion`: at the scan before.
  void learn(const MotionModel& motion, const PlanarScan& scan, const Pose2& matched);

  /// The match of `scan` agrees, or there was none: goes on from `motion`, which is at `scan`.
  void follow(const MotionModel& motion);
  /// The match of `scan` is contradicted: goes on by the IMU alone.
  void goOn(const PlanarScan& scan);
  void reset() { alone_.reset(); }

 private:
  static bool isMeasured(const MotionModel& motion, const PlanarScan& scan);

  std::optional<MotionModel> alone_;
  double scans_ = 1.0;  ///< from the match that agreed to the next scan
  /// Usual distance from the prediction by the IMU to the match, one scan after another, m.
  double usual_m_ = kFirstM;
  static constexpr double kFirstM = 0.02;
};

}  // namespace kestrel
