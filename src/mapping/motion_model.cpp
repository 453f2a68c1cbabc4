// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/motion_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// Maximum motion between two scans, m. After a larger one (the vehicle was carried, or its pose
/// jumped) the motion is not used for the prediction.
constexpr double kMaxStepM = 1.0;
/// Largest factor of the search windows after a long time in the lost state.
constexpr double kMaxSearchScale = 8.0;
/// A pose that is farther from the prediction than this speed explains must have a much better
/// score. A room that looks different at another height must not cause a jump.
constexpr double kMaxSpeed = 3.0;  // m/s
constexpr double kMinPlausibleM = 0.05;

/// Maximum turn rate of a vehicle, and noise of the yaw.
constexpr double kMaxTurnRate = 12.0;  // rad/s
constexpr double kTurnNoise = 0.1;     // rad
/// After this many consecutive lost scans the yaw is unknown: the vehicle may have been rotated by
/// hand.
constexpr int kTrustedLostScans = 40;

/// The prediction of a pose filter is not used over a longer time or for a faster motion.
constexpr double kMaxPredicted_s = 5.0;
constexpr double kMaxPredictedSpeed = 10.0;  // m/s

/// Time constant of the velocity, s.
constexpr double kVelocityTime = 0.15;

/// Positions farther from the origin are invalid and not used.
constexpr double kMaxPositionM = 1e6;

Pose2 halfway(const Pose2& a, const Pose2& b) { return interpolate(a, b, 0.5); }

}  // namespace

bool isUsable(const Pose2& pose) {
  return pose.isFinite() && std::abs(pose.x) < kMaxPositionM && std::abs(pose.y) < kMaxPositionM;
}

MotionModel::MotionModel(const MapperConfig& config, const Pose2& map_T_base)
    : gap_s_(config.gap_s),
      wide_window_m_(config.matcher.wide_window.linear_m),
      pose_(map_T_base) {}

/// The initial guesses, best first ([Xie 2010, eq. 5-6]: constant velocity). Odometry is not the
/// first one: its bias would pull every scan in a corridor slightly in the same direction.
MatchRequest MotionModel::request(const Points& points, const PlanarScan& scan,
                                  const std::optional<Pose2>& odom_T_base) const {
  MatchRequest result{points, pose_, {}, false, 1.0};
  const Pose2 continued = pose_ * motion_;
  result.initial_guesses = {continued, pose_, halfway(pose_, continued)};
  const std::optional<double> turn = yawChangeSince(scan);
  const bool has_turn = turn.has_value();
  if (has_turn) {
    // The gyro measures the rotation better than a motion model. At typical scan rates the smoothed
    // velocity is more accurate than the difference of two noisy poses. The guess without both is
    // the last one.
    const double yaw = pose_.yaw + *turn;
    const double seconds = std::clamp(scan.time - time_, 0.0, gap_s_);
    const Eigen::Vector2d moved =
        pose_.translation() + seconds * (velocity_ + 0.5 * velocityChangeSince(scan));
    const Pose2 predicted(moved.x(), moved.y(), yaw), turned(pose_.x, pose_.y, yaw);
    result.initial_guesses = {predicted, turned, halfway(turned, predicted), continued};
    result.trusted =
        integrated_acceleration_ && scan.integrated_acceleration && lost_scans_ == 0 && !placed_;
  }
  if (odom_ && odom_T_base) {
    const auto place =
        lost_scans_ > 0 ? result.initial_guesses.begin() : result.initial_guesses.end();
    result.initial_guesses.insert(place, pose_ * (odom_->inverse() * *odom_T_base));
  }
  const std::optional<Pose2> moved = filterMotionSince(scan);
  if (moved) {
    // If this guess fits poorly, the reason is rarely the guess. Two other guesses are enough.
    result.initial_guesses.resize(2);
    result.initial_guesses.insert(result.initial_guesses.begin(), pose_ * *moved);
    result.trusted = lost_scans_ == 0 && !placed_ && scan.time - time_ <= gap_s_;
  }
  result.yaw_known = (has_turn || moved) && lost_scans_ < kTrustedLostScans;
  result.lost = lost_scans_ > 0 || scan.time - time_ > gap_s_;
  result.search_all_yaws = result.lost && !result.yaw_known;
  if (result.lost) {
    const double distance = kMaxSpeed * (scan.time - found_time_);
    result.search_scale = std::clamp(1.0 + distance / wide_window_m_, 1.0, kMaxSearchScale);
  }
  result.plausible_m = std::max(kMinPlausibleM, kMaxSpeed * (scan.time - found_time_));
  if (placed_) result.plausible_m = std::numeric_limits<double>::infinity();
  return result;
}

/// Yaw change by the gyro since the last scan, rad. Nothing after a gap, or if the integrated yaw
/// was restarted.
std::optional<double> MotionModel::yawChangeSince(const PlanarScan& scan) const {
  const double seconds = scan.time - time_;
  if (!integrated_yaw_ || !scan.integrated_yaw || !(seconds <= gap_s_)) return std::nullopt;
  const double turn = *scan.integrated_yaw - *integrated_yaw_;
  return std::abs(turn) <= kMaxTurnRate * seconds + kTurnNoise ? std::optional(turn) : std::nullopt;
}

/// The motion since the last scan by a pose filter, which is the best prediction.
std::optional<Pose2> MotionModel::filterMotionSince(const PlanarScan& scan) const {
  const double seconds = scan.time - time_;
  if (!filter_pose_ || !scan.predicted || !(seconds <= kMaxPredicted_s)) return std::nullopt;
  const Pose2 moved = filter_pose_->inverse() * *scan.predicted;
  const bool possible = moved.distance() <= kMaxPredictedSpeed * std::max(0.0, seconds) &&
                        std::abs(moved.yaw) <= kMaxTurnRate * seconds + kTurnNoise;
  return possible ? std::optional(moved) : std::nullopt;
}

/// Velocity change by the accelerometer since the last scan, in the map frame, m/s.
Eigen::Vector2d MotionModel::velocityChangeSince(const PlanarScan& scan) const {
  if (!yawChangeSince(scan) || !integrated_acceleration_ || !scan.integrated_acceleration)
    return Eigen::Vector2d::Zero();
  return Eigen::Rotation2Dd(pose_.yaw - *integrated_yaw_) *
         (*scan.integrated_acceleration - *integrated_acceleration_);
}

PredictionSource MotionModel::predictionSourceOf(const PlanarScan& scan,
                                                 const std::optional<Pose2>& odom_T_base) const {
  if (filterMotionSince(scan)) return PredictionSource::kAccelerometer;
  if (odom_ && odom_T_base) return PredictionSource::kOdometry;
  return yawChangeSince(scan) && integrated_acceleration_ && scan.integrated_acceleration
             ? PredictionSource::kAccelerometer
             : PredictionSource::kVelocity;
}

std::optional<Pose2> MotionModel::motionPrediction(const MatchRequest& request,
                                                   const PlanarScan& scan,
                                                   const std::optional<Pose2>& odom_T_base) const {
  const double seconds = scan.time - time_;
  if (lost_scans_ > 0 || placed_ || !(seconds >= 0.0) || seconds > gap_s_) return std::nullopt;
  const bool by_odometry = odom_ && odom_T_base && !filterMotionSince(scan);
  return by_odometry ? pose_ * (odom_->inverse() * *odom_T_base) : request.initial_guesses.front();
}

double MotionModel::secondsSince(const PlanarScan& scan) const {
  return std::min(std::max(0.0, scan.time - time_), gap_s_);
}

void MotionModel::move(const Pose2& found, const Pose2& predicted, bool lost,
                       const PlanarScan& scan) {
  const Pose2 next = !lost ? found : isUsable(predicted) ? predicted : pose_;
  motion_ = lost || placed_ ? Pose2() : pose_.inverse() * next;
  if (motion_.distance() > kMaxStepM) motion_ = Pose2();
  updateVelocity(next, scan, lost || placed_);
  pose_ = next;
  lost_scans_ = lost ? lost_scans_ + 1 : 0;
  placed_ = false;
}

/// The velocity is smoothed, because over one period of a 40 Hz laser the noise of the poses is as
/// large as the motion. The accelerometer gives changes without delay. While lost, the velocity is
/// kept.
void MotionModel::updateVelocity(const Pose2& next, const PlanarScan& scan, bool unknown) {
  const double seconds = scan.time - time_;
  const Eigen::Vector2d gained = velocityChangeSince(scan);
  if (placed_ || !(seconds > 0.0) || seconds > gap_s_) {
    velocity_.setZero();
    return;
  }
  if (unknown) {
    velocity_ = scan.integrated_acceleration ? Eigen::Vector2d(velocity_ + gained)
                                             : Eigen::Vector2d::Zero();
    return;
  }
  const Eigen::Vector2d measured = (next.translation() - pose_.translation()) / seconds;
  const Eigen::Vector2d correction = measured - (velocity_ + 0.5 * gained);
  velocity_ += gained + seconds / (seconds + kVelocityTime) * correction;
}

void MotionModel::remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                           bool lost) {
  odom_ = odom_T_base;
  filter_pose_ = scan.predicted;
  integrated_yaw_ = scan.integrated_yaw;
  integrated_acceleration_ = scan.integrated_acceleration;
  time_ = scan.time;
  if (!lost) found_time_ = scan.time;
}

void MotionModel::setPose(const Pose2& map_T_base) {
  pose_ = map_T_base;
  motion_ = Pose2();
  odom_.reset();
  filter_pose_.reset();
  integrated_yaw_.reset();
  velocity_.setZero();
  placed_ = true;
}

}  // namespace kestrel
