// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/motion_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// A vehicle that seems to move farther than this between two scans was moved, or jumped in the
/// map: its motion says nothing of the next one.
constexpr double kMaxStepM = 1.0;
/// Largest factor of the search windows after a long lost state.
constexpr double kMaxSearchScale = 8.0;
/// A scan that seems to be farther from the prediction than this speed explains has to fit much
/// better there: a room that looks different from another height is no reason to jump.
constexpr double kMaxSpeed = 3.0;  // m/s
constexpr double kMinPlausibleM = 0.05;

/// No vehicle turns faster, and the yaw is no more noisy than this.
constexpr double kMaxTurnRate = 12.0;  // rad/s
constexpr double kTurnNoise = 0.1;     // rad
/// Lost for longer than this in a row, the vehicle may have been turned by hand.
constexpr int kTrustedLostScans = 40;

/// What a pose filter says of a longer absence, or of a faster vehicle, is no prediction.
constexpr double kMaxPredicted_s = 5.0;
constexpr double kMaxPredictedSpeed = 10.0;  // m/s

/// Time constant of the velocity, s.
constexpr double kVelocityTime = 0.15;

/// No vehicle flies farther from its start: beyond this a number is broken and is not used.
constexpr double kMaxPositionM = 1e6;

Pose2 halfway(const Pose2& a, const Pose2& b) {
  return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y), a.yaw + 0.5 * normalizeAngle(b.yaw - a.yaw)};
}

}  // namespace

bool isUsable(const Pose2& pose) {
  return pose.isFinite() && std::abs(pose.x) < kMaxPositionM && std::abs(pose.y) < kMaxPositionM;
}

MotionModel::MotionModel(const MapperConfig& config, const Pose2& map_T_base)
    : gap_s_(config.gap_s),
      wide_window_m_(config.matcher.wide_window.linear_m),
      pose_(map_T_base) {}

/// The starts, best first (paper 002 eq. 5-6: the motion goes on as it was). Odometry comes second:
/// its bias would otherwise pull every scan of a corridor a little the same way.
MatchRequest MotionModel::request(const Points& points, const PlanarScan& scan,
                                  const std::optional<Pose2>& odom_T_base) const {
  MatchRequest result{points, pose_, {}, false, 1.0};
  const Pose2 continued = pose_ * motion_;
  result.initial_guesses = {continued, pose_, halfway(pose_, continued)};
  const std::optional<double> turn = turnSince(scan);
  const bool has_turn = turn.has_value();
  if (has_turn) {
    // The gyro knows the rotation better than any motion model, and at the rate of such lasers the
    // smoothed velocity the motion better than two noisy poses. Without both in the last place.
    const double yaw = pose_.yaw + *turn;
    const double seconds = std::clamp(scan.time - time_, 0.0, gap_s_);
    const Eigen::Vector2d moved =
        pose_.translation() + seconds * (velocity_ + 0.5 * gainedSpeed(scan));
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
  const std::optional<Pose2> moved = predictedSince(scan);
  if (moved) {
    // Where that fits badly it is rarely for the initial guess: our own prediction and none have to
    // do.
    result.initial_guesses.resize(2);
    result.initial_guesses.insert(result.initial_guesses.begin(), pose_ * *moved);
    result.trusted = lost_scans_ == 0 && !placed_ && scan.time - time_ <= gap_s_;
  }
  result.turn_known = (has_turn || moved) && lost_scans_ < kTrustedLostScans;
  result.lost = lost_scans_ > 0 || scan.time - time_ > gap_s_;
  result.search_all_round = result.lost && !result.turn_known;
  if (result.lost) {
    const double flown = kMaxSpeed * (scan.time - found_time_);
    result.search_scale = std::clamp(1.0 + flown / wide_window_m_, 1.0, kMaxSearchScale);
  }
  result.plausible_m = std::max(kMinPlausibleM, kMaxSpeed * (scan.time - found_time_));
  if (placed_) result.plausible_m = std::numeric_limits<double>::infinity();
  return result;
}

/// What the gyro says of the turn since the last scan, rad; nothing after a gap, or where the
/// yaw began anew.
std::optional<double> MotionModel::turnSince(const PlanarScan& scan) const {
  const double seconds = scan.time - time_;
  if (!integrated_yaw_ || !scan.integrated_yaw || !(seconds <= gap_s_)) return std::nullopt;
  const double turn = *scan.integrated_yaw - *integrated_yaw_;
  return std::abs(turn) <= kMaxTurnRate * seconds + kTurnNoise ? std::optional(turn) : std::nullopt;
}

/// The motion since the last scan by a pose filter: the best that there is.
std::optional<Pose2> MotionModel::predictedSince(const PlanarScan& scan) const {
  const double seconds = scan.time - time_;
  if (!predicted_ || !scan.predicted || !(seconds <= kMaxPredicted_s)) return std::nullopt;
  const Pose2 moved = predicted_->inverse() * *scan.predicted;
  const bool possible = moved.distance() <= kMaxPredictedSpeed * std::max(0.0, seconds) &&
                        std::abs(moved.yaw) <= kMaxTurnRate * seconds + kTurnNoise;
  return possible ? std::optional(moved) : std::nullopt;
}

/// What the accelerometer says of the velocity since the last scan, in map, m/s.
Eigen::Vector2d MotionModel::gainedSpeed(const PlanarScan& scan) const {
  if (!turnSince(scan) || !integrated_acceleration_ || !scan.integrated_acceleration)
    return Eigen::Vector2d::Zero();
  return Eigen::Rotation2Dd(pose_.yaw - *integrated_yaw_) *
         (*scan.integrated_acceleration - *integrated_acceleration_);
}

PredictionSource MotionModel::predictionSourceOf(const PlanarScan& scan,
                                                 const std::optional<Pose2>& odom_T_base) const {
  if (predictedSince(scan)) return PredictionSource::kAccelerometer;
  if (odom_ && odom_T_base) return PredictionSource::kOdometry;
  return turnSince(scan) && integrated_acceleration_ && scan.integrated_acceleration
             ? PredictionSource::kAccelerometer
             : PredictionSource::kVelocity;
}

std::optional<Pose2> MotionModel::motionPrediction(const MatchRequest& request,
                                                   const PlanarScan& scan,
                                                   const std::optional<Pose2>& odom_T_base) const {
  const double seconds = scan.time - time_;
  if (lost_scans_ > 0 || placed_ || !(seconds >= 0.0) || seconds > gap_s_) return std::nullopt;
  const bool by_odometry = odom_ && odom_T_base && !predictedSince(scan);
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

/// Smoothed: over one period of a 40 Hz laser the noise of the poses is as large as the motion. The
/// accelerometer, where there is one, tells the changes without delay; a lost vehicle flies on.
void MotionModel::updateVelocity(const Pose2& next, const PlanarScan& scan, bool unknown) {
  const double seconds = scan.time - time_;
  const Eigen::Vector2d gained = gainedSpeed(scan);
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
  predicted_ = scan.predicted;
  integrated_yaw_ = scan.integrated_yaw;
  integrated_acceleration_ = scan.integrated_acceleration;
  time_ = scan.time;
  if (!lost) found_time_ = scan.time;
}

void MotionModel::setPose(const Pose2& map_T_base) {
  pose_ = map_T_base;
  motion_ = Pose2();
  odom_.reset();
  predicted_.reset();
  integrated_yaw_.reset();
  velocity_.setZero();
  placed_ = true;
}

}  // namespace kestrel
