// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/odometry_sign.h"

namespace kestrel {

/// Standard deviations of a motion.
struct MotionError {
  double position_m = 0.0;  ///< along x and along y
  double yaw_rad = 0.0;
};

/// The errors of an odometry, learned from matches. Before anything is learned: 30 % of the
/// distance and of the rotation, and 0.09 rad per meter.
///
/// Systematic errors (a wrong scale, a turn per meter) are corrected. The size of the remaining
/// errors is measured, so that an exact odometry is trusted more and a bad one less. An odometry
/// that does not know the direction gets the one in which the vehicle drives. Motions are
/// compared in segments of a meter, because over one scan the errors of the matches are as large
/// as those of the odometry.
class OdometryModel {
 public:
  /// The motion without the systematic errors, in the likelier direction. `measured`: in the base
  /// frame at its beginning.
  Pose2 corrected(const Pose2& measured) const;

  /// The error of `corrected(measured)`.
  MotionError errorOf(const Pose2& measured) const;
  /// The same if the direction is right.
  MotionError errorAlongDirection(const Pose2& measured) const;

  const OdometrySign& sign() const { return sign_; }
  /// Whether the motion that was matched is against the odometry.
  bool isReversed(const Pose2& measured, const Pose2& matched) const;

  /// Learns from a step that was matched well in every direction.
  void learn(const Pose2& measured, const Pose2& matched);

  /// Learns from a step that was matched, well or not, how the direction changes.
  void follow(const Pose2& measured, const Pose2& matched);

  /// The next step does not continue the last one.
  void interrupt();

 private:
  struct Segment {
    Pose2 measured, matched;
    double path_m = 0.0, turn_rad = 0.0;
  };

  Pose2 withoutSystematic(const Pose2& measured) const;
  void learnSegment();
  void learnSystematic(double distance_m);

  OdometrySign sign_;
  Segment segment_;
  /// Sums for the least squares fits of the scale, and of the yaw error to rotation and distance.
  double squares_ = 0.0, products_ = 0.0;
  Eigen::Matrix2d yaw_normals_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d yaw_right_ = Eigen::Vector2d::Zero();
  double scale_ = 1.0;
  Eigen::Vector2d yaw_gains_ = Eigen::Vector2d::Zero();  ///< per rad and per m
  /// The mean squared errors of an unknown odometry are this many times those of an ordinary one.
  static constexpr double kUnknownRatio = 9.0;
  /// Mean squared errors, relative to those of an ordinary odometry, and their weight in segments.
  double position_ratio_ = kUnknownRatio, yaw_ratio_ = kUnknownRatio, weight_ = 0.0;
};

}  // namespace kestrel
