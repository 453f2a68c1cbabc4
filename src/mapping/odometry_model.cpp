// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/square.h"

namespace kestrel {
namespace {

/// Unit of the errors, relative to the distance and to the rotation, and of the yaw per meter:
/// those of an ordinary odometry.
constexpr double kRelativeError = 0.1, kYawPerMeter = 0.03;
/// Smallest errors: of a step, and of the matches at the ends of a segment.
constexpr double kLeastM = 0.002, kLeastRad = 0.001;
constexpr double kMatchM = 0.015, kMatchRad = 0.005;
/// A segment ends after this distance or rotation.
constexpr double kSegmentM = 1.0, kSegmentRad = 0.5;
/// The assumed errors count as much as this many segments. Older segments are forgotten with this
/// number of segments as time constant.
constexpr double kAssumedSegments = 5.0, kMemorySegments = 50.0;
constexpr double kKept = 1.0 - 1.0 / kMemorySegments;
/// A squared error that is this many times larger than the mean one is a slip, or the match was
/// wrong. It is no systematic error, and counts as this much only.
constexpr double kSlipRatio = 9.0;
/// Limits of the scale. Beyond them the unit is wrong, or the data.
constexpr double kMinScale = 0.5, kMaxScale = 2.0;

/// Variances of the assumed errors of a motion, m² and rad².
double assumedPosition(double distance_m) { return square(kRelativeError * distance_m); }
double assumedYaw(double distance_m, double turn_rad) {
  return square(kYawPerMeter * distance_m) + square(kRelativeError * turn_rad);
}

/// One step of a running mean.
void average(double value, double weight, double& mean) { mean += (value - mean) / weight; }

}  // namespace

Pose2 OdometryModel::corrected(const Pose2& measured) const {
  const Pose2 result = withoutSystematic(measured);
  return sign_.isReversedNext() ? reversed(result) : result;
}

Pose2 OdometryModel::withoutSystematic(const Pose2& measured) const {
  const Eigen::Vector2d gain_of(measured.yaw, measured.distance());
  return {scale_ * measured.x, scale_ * measured.y, measured.yaw + yaw_gains_.dot(gain_of)};
}

MotionError OdometryModel::errorOf(const Pose2& measured) const {
  MotionError result = errorAlongDirection(measured);
  // In the wrong direction the vehicle is twice as far away.
  const double apart = 2.0 * measured.distance() * std::sqrt(sign_.wrongShare());
  result.position_m = std::hypot(result.position_m, apart);
  return result;
}

MotionError OdometryModel::errorAlongDirection(const Pose2& measured) const {
  const double moved = measured.distance();
  return {kLeastM + std::sqrt(position_ratio_ * assumedPosition(moved)),
          kLeastRad + std::sqrt(yaw_ratio_ * assumedYaw(moved, measured.yaw))};
}

bool OdometryModel::isReversed(const Pose2& measured, const Pose2& matched) const {
  return sign_.isReversed(measured, matched, errorAlongDirection(measured).position_m);
}

void OdometryModel::follow(const Pose2& measured, const Pose2& matched) {
  sign_.follow(measured, matched, errorAlongDirection(measured).position_m);
}

void OdometryModel::interrupt() {
  segment_ = Segment();
  sign_.interrupt();
}

void OdometryModel::learn(const Pose2& measured, const Pose2& matched) {
  sign_.learn(measured, matched, errorAlongDirection(measured).position_m);
  const bool is_reversed = isReversed(measured, matched);
  segment_.measured = segment_.measured * (is_reversed ? reversed(measured) : measured);
  segment_.matched = segment_.matched * matched;
  segment_.path_m += measured.distance();
  segment_.turn_rad += std::abs(measured.yaw);
  if (segment_.path_m < kSegmentM && segment_.turn_rad < kSegmentRad) return;
  learnSegment();
  segment_ = Segment();
}

void OdometryModel::learnSegment() {
  const Pose2 expected = withoutSystematic(segment_.measured);
  const double position = (segment_.matched.translation() - expected.translation()).squaredNorm() /
                          (assumedPosition(segment_.path_m) + square(kMatchM));
  const double yaw = square(normalizeAngle(segment_.matched.yaw - expected.yaw)) /
                     (assumedYaw(segment_.path_m, segment_.turn_rad) + square(kMatchRad));
  const bool slipped = position > kSlipRatio * std::max(1.0, position_ratio_) ||
                       yaw > kSlipRatio * std::max(1.0, yaw_ratio_);
  if (!slipped) learnSystematic(segment_.measured.distance());
  weight_ = std::clamp(weight_ + 1.0, kAssumedSegments + 1.0, kMemorySegments);
  average(std::min(position, kSlipRatio * position_ratio_), weight_, position_ratio_);
  average(std::min(yaw, kSlipRatio * yaw_ratio_), weight_, yaw_ratio_);
}

void OdometryModel::learnSystematic(double distance_m) {
  constexpr double kAssumed = kAssumedSegments * kSegmentM * kSegmentM;
  const Pose2 &measured = segment_.measured, &matched = segment_.matched;
  squares_ = kKept * squares_ + square(distance_m);
  products_ = kKept * products_ + measured.translation().dot(matched.translation());
  // Random errors of the odometry make its motion look too long, and a fit gives too small a scale
  // and too small a turn. So the more of them there are, the more weight has what was assumed.
  const double scale_weight = kAssumed * std::max(1.0, position_ratio_);
  scale_ = std::clamp((products_ + scale_weight) / (squares_ + scale_weight), kMinScale, kMaxScale);
  const Eigen::Vector2d cause(measured.yaw, distance_m);
  yaw_normals_ = kKept * yaw_normals_ + cause * cause.transpose();
  yaw_right_ = kKept * yaw_right_ + normalizeAngle(matched.yaw - measured.yaw) * cause;
  const Eigen::Vector2d assumed =
      std::max(1.0, yaw_ratio_) * Eigen::Vector2d(kAssumedSegments * square(kSegmentRad), kAssumed);
  const Eigen::Matrix2d normals = yaw_normals_ + Eigen::Matrix2d(assumed.asDiagonal());
  yaw_gains_ = normals.inverse() * yaw_right_;
}

}  // namespace kestrel
