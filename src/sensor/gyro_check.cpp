// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/gyro_check.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

/// Pairs with less rotation are noise, rad.
constexpr double kMoving = 0.03;
constexpr double kKept = 0.98;      // weight of the old pairs: about 50 pairs count
constexpr int kFewest = 4;          // pairs before a verdict on a unit
constexpr double kLongPath = 1.0;   // rad; before any other verdict
constexpr double kZeroShare = 0.1;  // a sensor that measures less of the rotation does not move
constexpr double kAligned = 0.9;    // correlation of the same rotation
constexpr double kReversed = -0.7;  // correlation of opposite rotations
constexpr double kUnrelated = 0.2;  // correlation of sensors with different axes
constexpr double kUnitTolerance = 0.3;

constexpr double kStep = 0.1;      // s
constexpr double kMaxPause = 0.5;  // s; no comparison over longer pauses
constexpr int kLongStep = 5;       // steps
/// The gyro is in doubt if it claims this much more rotation in a step than the orientation: a
/// factor, and rad.
constexpr double kDoubtFactor = 5.0, kDoubtRad = 0.1;
/// A gyro that reads exactly zero in a step is in doubt if the orientation turns further, rad.
constexpr double kStandsStill = 0.01;

Eigen::Vector3d rotationVector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return normalizeAngle(turn.angle()) * turn.axis();
}

}  // namespace

void RotationComparison::add(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  const double a = first.norm(), b = second.norm();
  if (!(std::max(a, b) > kMoving)) return;
  ++pairs_;
  for (double* sum : {&first_path_, &second_path_, &first_squares_, &second_squares_, &products_}) {
    *sum *= kKept;
  }
  first_path_ += a;
  second_path_ += b;
  first_squares_ += a * a;
  second_squares_ += b * b;
  products_ += first.dot(second);
}

RotationVerdict RotationComparison::verdict() const {
  if (pairs_ < kFewest) return RotationVerdict::kUnknown;
  const double size = std::sqrt(first_squares_ * second_squares_);
  const double correlation = size > 0.0 ? products_ / size : 0.0;
  const double factor = std::sqrt(first_squares_ / std::max(second_squares_, 1e-12));
  const double degrees = radToDeg(1.0);
  if (correlation > kAligned && std::abs(factor - degrees) < kUnitTolerance * degrees) {
    return RotationVerdict::kDegrees;
  }
  if (std::max(first_path_, second_path_) < kLongPath) return RotationVerdict::kUnknown;
  if (first_path_ < kZeroShare * second_path_) return RotationVerdict::kFirstZero;
  // Degrees would be 1 / 57 of the path, in the same direction.
  if (second_path_ < kZeroShare / degrees * first_path_) return RotationVerdict::kSecondZero;
  if (correlation < kReversed) return RotationVerdict::kOpposite;
  if (correlation < kUnrelated) return RotationVerdict::kDifferent;
  return correlation > kAligned ? RotationVerdict::kAgree : RotationVerdict::kUnknown;
}

void GyroCheck::add(const ImuSample& sample) {
  if (!sample.world_R_imu || !sample.angular_velocity) return;
  const double dt = last_ ? sample.stamp - last_->stamp : kMaxPause;
  if (dt <= 0.0 && dt > -kMaxPause) return;  // late, or sent twice
  const Eigen::Quaterniond orientation = sample.world_R_imu->normalized();
  const bool continues = last_ && dt > 0.0 && dt <= kMaxPause;
  if (continues) {
    step_gyro_ += 0.5 * dt * (*last_->angular_velocity + *sample.angular_velocity);
    step_s_ += dt;
  }
  last_ = sample;
  const Eigen::Vector3d turned = rotationVector(step_start_.conjugate() * orientation);
  if (continues && verdict_ != RotationVerdict::kAgree && isDoubtful(turned)) doubts_ = true;
  if (continues && step_s_ < kStep) return;
  if (continues) {
    doubts_ = isDoubtful(turned);
    addStep(step_gyro_, turned);
  }
  step_s_ = 0.0;
  step_gyro_.setZero();
  step_start_ = orientation;
}

void GyroCheck::interrupt() {
  const RotationVerdict known = verdict_;
  restart();
  if (known == RotationVerdict::kDegrees) verdict_ = known;
}

bool GyroCheck::isDoubtful(const Eigen::Vector3d& turned) const {
  if (step_gyro_.isZero(0.0)) return turned.norm() > kStandsStill;
  return step_gyro_.norm() > kDoubtFactor * turned.norm() + kDoubtRad;
}

void GyroCheck::addStep(const Eigen::Vector3d& gyro, const Eigen::Vector3d& orientation) {
  steps_.add(gyro, orientation);
  gyro_sum_ += gyro;
  orientation_sum_ += orientation;
  if (++summed_ == kLongStep) {
    long_steps_.add(gyro_sum_, orientation_sum_);
    summed_ = 0;
    gyro_sum_.setZero();
    orientation_sum_.setZero();
  }
  const RotationVerdict quick = steps_.verdict(), slow = long_steps_.verdict();
  if (quick == RotationVerdict::kDegrees || quick == RotationVerdict::kAgree) {
    verdict_ = quick;
  } else if (slow != RotationVerdict::kUnknown) {
    verdict_ = slow;
  }
  if (verdict_ == RotationVerdict::kAgree) doubts_ = false;  // the orientation is only slow
}

}  // namespace kestrel
