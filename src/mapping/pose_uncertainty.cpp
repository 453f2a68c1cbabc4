// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/pose_uncertainty.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/geometry/square.h"
#include "kestrel_slam/geometry/symmetric_axes.h"
#include "kestrel_slam/matching/covariance.h"

namespace kestrel {
namespace {

/// Smallest standard deviations of the pose of a lost vehicle.
constexpr double kLostM = 1.0, kLostRad = 0.5;

/// Uncertainty of the map at the first scan: discretization errors of the cells and errors of the
/// attitude shift and rotate the reference of all later scans.
constexpr double kFirstM = 0.004, kFirstRad = 0.0008;
/// The errors of neighboring scans are correlated, so they do not average out in the map. The
/// covariance of a chain of scans grows by this factor faster. Calibrated on simulated flights
/// (measure_flights).
constexpr double kChainFactor = 4.5;

/// Standard deviation of the velocity when a direction becomes unobservable, m/s.
constexpr double kFirstSpeed = 0.05, kFirstLaserSpeed = 0.15;
/// Growth of the velocity error, m/s², for an accelerometer with a tilt error of a third of a
/// degree.
constexpr double kAccelerometerError = 0.05;
/// Unknown acceleration of the vehicle, m/s², how long it lasts, s, and the largest error of the
/// speed, m/s.
constexpr double kUnknownAcceleration = 1.0, kAccelerationTime = 0.5, kMaxSpeed = 3.0;
/// Error of the odometry, relative to the distance.
constexpr double kOdometryError = 0.1;

Eigen::Matrix3d absolute(const Eigen::Matrix3d& symmetric) {
  const SymmetricAxes<3> axes = symmetricAxes(symmetric);
  return axes.eigenvectors * axes.eigenvalues.cwiseAbs().asDiagonal() *
         axes.eigenvectors.transpose();
}

/// `covariance`, but in no direction more than `limit`, which is positive definite.
Eigen::Matrix3d limited(const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& limit) {
  const Eigen::LLT<Eigen::Matrix3d> factor(limit);
  if (factor.info() != Eigen::Success) return covariance;
  const Eigen::Matrix3d root = factor.matrixL();
  const Eigen::Matrix3d half = factor.matrixL().solve(covariance);
  const SymmetricAxes<3> axes =
      symmetricAxes(Eigen::Matrix3d(factor.matrixL().solve(half.transpose())));
  const Eigen::Matrix3d axes_in_map = root * axes.eigenvectors;
  return axes_in_map * axes.eigenvalues.cwiseMin(1.0).asDiagonal() * axes_in_map.transpose();
}

/// The part of the map, and that of both matches, in the axes of the map.
std::pair<Eigen::Matrix3d, Eigen::Matrix3d> partsOf(const UncertainPose& a,
                                                    const UncertainPose& b) {
  const Eigen::Vector2d a_to_b = b.pose.translation() - a.pose.translation();
  return {absolute(b.map_covariance - transported(a.map_covariance, a_to_b)),
          b.match_covariance + transported(a.match_covariance, a_to_b)};
}

}  // namespace

Eigen::Matrix3d relativeCovariance(const UncertainPose& a, const UncertainPose& b) {
  const auto [map, matches] = partsOf(a, b);
  return rotated(map + matches, -a.pose.yaw);
}

UncertainPose placedAt(const Pose2& pose, const UncertainPose& uncertain) {
  const double turn = pose.yaw - uncertain.pose.yaw;
  return {pose, rotated(uncertain.map_covariance, turn), rotated(uncertain.match_covariance, turn)};
}

void PoseUncertainty::begin(const Pose2& pose) {
  last_ = UncertainPose();
  last_.pose = pose;
  last_.map_covariance.diagonal() << square(kFirstM), square(kFirstM), square(kFirstRad);
  found_ = last_.covariance();
  found_pose_ = pose;
}

void PoseUncertainty::insert() {
  map_.add(last_.pose, last_.map_covariance + kChainFactor * last_.match_covariance);
  inserted_variance_ = drift_variance_;
  followed_ = clear_;
}

/// The pose may have been found by walls of very different age at both ends. Then the difference of
/// their covariances says nothing about the motion. A scan that sees what the inserted one saw is
/// never less certain than a match with that scan alone would be.
Eigen::Matrix3d PoseUncertainty::motionSince(const UncertainPose& inserted) const {
  if (!followed_) return relativeCovariance(inserted, last_);
  const auto [map, matches] = partsOf(inserted, last_);
  return rotated(limited(map, kChainFactor * matches) + matches, -inserted.pose.yaw);
}

Eigen::Matrix3d PoseUncertainty::lastingSince(const UncertainPose& inserted) const {
  const auto [map, matches] = partsOf(inserted, last_);
  return rotated(followed_ ? limited(map, kChainFactor * matches) : map, -inserted.pose.yaw);
}

double PoseUncertainty::driftSinceInsertion() const {
  return drifting_ ? std::sqrt(drift_variance_ - inserted_variance_) : 0.0;
}

void PoseUncertainty::update(const SurfelField& surface, const Points& points,
                             const MatchResult& match, double seconds, double moved_m,
                             PredictionSource prediction_source) {
  UncertainPose next{match.pose, map_.at(surface, points, match.pose), match.covariance};
  const Eigen::Vector2d& along = match.degenerate_direction;
  if (match.degenerate && !drifting_) {
    entry_variance_ = along.dot(last_.covariance().topLeftCorner<2, 2>() * along);
    drift_variance_ = inserted_variance_ = 0.0;
  }
  // A match that is not clear along a weak direction does not make it a strong one.
  const bool is_weak =
      match.degenerate || match.constraint < kWeakConstraint || (weak_ && match.unclear_along);
  if (is_weak) {
    if (!weak_) {
      along_ = drifted_ = firstError(along, prediction_source);
      base_variance_ = along.dot(last_.map_covariance.topLeftCorner<2, 2>() * along);
    }
    const bool nothing_shown = match.unclear_along || (match.degenerate && !match.predicted_along);
    drift(seconds, moved_m, prediction_source,
          nothing_shown ? std::numeric_limits<double>::infinity() : match.along_variance);
  }
  if (is_weak && prediction_source == PredictionSource::kVelocity) {
    next.map_covariance = stretched(next.map_covariance, along, 0.0);
    next.match_covariance = stretched(next.match_covariance, along, 0.0);
    next.map_covariance.topLeftCorner<2, 2>() +=
        (base_variance_ + drifted_.covariance(0, 0)) * along * along.transpose();
  } else if (match.degenerate) {
    next.map_covariance = stretched(next.map_covariance, along, 0.0);
    next.match_covariance = stretched(next.match_covariance, along, 0.0);
    next.map_covariance.topLeftCorner<2, 2>() +=
        (entry_variance_ + drift_variance_) * along * along.transpose();
  }
  drifting_ = match.degenerate;
  weak_ = is_weak;
  // With odometry the scans may be far apart, and so may those that had to be searched for.
  clear_ = prediction_source == PredictionSource::kVelocity && !is_weak && !match.unclear_along &&
           !match.mostly_predicted && !match.ambiguous && !match.searched;
  followed_ &= clear_;
  motion_ = relativeCovariance(last_, next);
  last_ = next;
  found_ = next.covariance();
  found_pose_ = next.pose;
  unmeasured_speed_m_s_ = is_weak
                              ? std::min(unmeasured_speed_m_s_, std::sqrt(along_.covariance(1, 1)))
                              : unmeasured_speed_m_s_ * kVelocityTime / (seconds + kVelocityTime);
}

void PoseUncertainty::setSpeedError(double sigma_m_s) {
  unmeasured_speed_m_s_ = sigma_m_s;
  drifting_ = weak_ = clear_ = followed_ = false;
}

double PoseUncertainty::speedError() const {
  return weak_ ? std::sqrt(along_.covariance(1, 1)) : unmeasured_speed_m_s_;
}

/// The error of an accelerometer or of odometry has the same sign for a long time, so standard
/// deviations are added. An unknown acceleration changes.
void AlongError::predict(double seconds, double moved_m, PredictionSource source) {
  if (source == PredictionSource::kVelocity) {
    Eigen::Matrix2d step, noise;
    step << 1.0, seconds, 0.0, 1.0;
    noise << seconds * seconds / 3.0, seconds / 2.0, seconds / 2.0, 1.0;
    covariance = step * covariance * step.transpose() +
                 square(kUnknownAcceleration) * kAccelerationTime * seconds * noise;
    limitSpeed(kMaxSpeed);
    return;
  }
  Eigen::Vector2d sigmas = covariance.diagonal().cwiseSqrt();
  if (source == PredictionSource::kOdometry) {
    sigmas.x() += kOdometryError * moved_m;
  } else {
    sigmas.x() += seconds * (sigmas.y() + 0.5 * seconds * kAccelerometerError);
    sigmas.y() += seconds * kAccelerometerError;
  }
  covariance = sigmas * sigmas.transpose();
}

void AlongError::limitSpeed(double sigma_m_s) {
  const double factor = std::min(1.0, sigma_m_s / std::sqrt(covariance(1, 1)));
  covariance.row(1) *= factor;
  covariance.col(1) *= factor;
}

/// The error of the speed of a filter or of an accelerometer comes back, because its cause remains.
void AlongError::correct(double variance, PredictionSource source) {
  if (!std::isfinite(variance)) return;
  Eigen::Vector2d column = covariance.col(0);
  if (source != PredictionSource::kVelocity) column.y() = 0.0;
  covariance -= column * column.transpose() / (covariance(0, 0) + variance);
}

/// The error along the unobservable direction at the beginning of a drift.
AlongError PoseUncertainty::firstError(const Eigen::Vector2d& along,
                                       PredictionSource source) const {
  const double speed = source == PredictionSource::kVelocity ? kFirstLaserSpeed : kFirstSpeed;
  AlongError result;
  result.covariance(0, 0) = along.dot(last_.match_covariance.topLeftCorner<2, 2>() * along);
  result.covariance(1, 1) = square(std::max(speed, unmeasured_speed_m_s_));
  return result;
}

AlongError PoseUncertainty::alongError(const MatchResult& match, double seconds, double moved_m,
                                       PredictionSource source) const {
  AlongError error = weak_ ? along_ : firstError(match.degenerate_direction, source);
  error.predict(seconds, moved_m, source);
  return error;
}

/// Extends the drift by one scan.
void PoseUncertainty::drift(double seconds, double moved_m, PredictionSource source,
                            double along_variance) {
  const double before = along_.covariance(0, 0);
  along_.predict(seconds, moved_m, source);
  drift_variance_ += along_.covariance(0, 0) - before;
  along_.correct(along_variance, source);
  // A few beams may be on another door frame, or on the floor ahead, which moves along.
  drifted_.predict(seconds, moved_m, source);
}

void PoseUncertainty::carry(const Pose2& predicted, const PredictionError& error) {
  unmeasured_speed_m_s_ = error.speed_m_s();
  predict(predicted, {error.position_m(), error.position_m(), error.yaw_rad()});
}

/// The motion since the last scan has the error, too: that scan may have been right.
void PoseUncertainty::doubt(const PredictionError& error) {
  const Eigen::Vector2d variance = Eigen::Vector2d::Constant(square(error.position_m()));
  last_.match_covariance.diagonal().head<2>() += variance;
  found_.diagonal().head<2>() += variance;
  motion_.diagonal().head<2>() += variance;
  clear_ = followed_ = false;
}

void PoseUncertainty::lose(const Pose2& predicted, const PredictionError& error) {
  const double linear = std::max(kLostM, error.position_m());
  predict(predicted, {linear, linear, std::max(kLostRad, error.yaw_rad())});
}

/// `sigmas`: of (x, y, yaw), of the motion since the last match.
void PoseUncertainty::predict(const Pose2& predicted, const Eigen::Vector3d& sigmas) {
  const UncertainPose next{predicted,
                           transported(found_, predicted.translation() - found_pose_.translation()),
                           Eigen::Matrix3d(sigmas.cwiseAbs2().asDiagonal())};
  motion_ = relativeCovariance(last_, next);
  last_ = next;
  drifting_ = weak_ = clear_ = followed_ = false;
}

}  // namespace kestrel
