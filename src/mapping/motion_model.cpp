// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/motion_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// Largest factor of the search windows after a long time in the lost state.
constexpr double kMaxSearchScale = 8.0;
/// A pose that is farther from the prediction than this speed explains must have a much better
/// score. A room that looks different at another height must not cause a jump.
constexpr double kSpeedLimit = 3.0;  // m/s
constexpr double kMinPlausibleM = 0.05;

/// Maximum turn rate of a vehicle, and noise of the yaw.
constexpr double kMaxTurnRate = 12.0;  // rad/s
constexpr double kTurnNoise = 0.1;     // rad

/// After this many consecutive lost scans the yaw is unknown: the gyro may be wrong.
constexpr int kTrustedLostScans = 40;

/// A motion is not predicted over a longer time, s. That of a pose filter or of the odometry is not
/// used if it is faster.
constexpr double kMaxPredicted_s = 10.0;
constexpr double kMaxPredictedSpeed = 10.0;  // m/s
/// The error of a prediction does not grow longer, s: nothing is known then.
constexpr double kMaxErrorTime = 600.0;
/// A prediction with a smaller error is accurate: the local match converges from it.
constexpr double kAccurateM = 0.05;
/// The windows of the search cover this many standard deviations.
constexpr double kSigmas = 3.0;

/// Positions farther from the origin are invalid and not used.
constexpr double kMaxPositionM = 1e6;

Pose2 halfway(const Pose2& a, const Pose2& b) { return interpolate(a, b, 0.5); }

}  // namespace

bool isUsable(const Pose2& pose) {
  return pose.isFinite() && std::abs(pose.x) < kMaxPositionM && std::abs(pose.y) < kMaxPositionM;
}

MotionModel::MotionModel(const MapperConfig& config, const Pose2& map_T_base)
    : gap_s_(config.gap_s),
      near_window_(config.matcher.near_window),
      wide_window_m_(config.matcher.wide_window.linear_m),
      pose_(map_T_base) {}

/// The initial guesses, best first ([Xie 2010, eq. 5-6]: constant velocity). Odometry is the first
/// one only where the match may not converge from the others: its bias would pull every scan in a
/// corridor slightly in the same direction.
std::vector<Pose2> MotionModel::initialGuesses(const PlanarScan& scan,
                                               const std::optional<Pose2>& odom_T_base) const {
  const Pose2 continued = pose_ * continued_.predict(std::max(0.0, scan.time - time_));
  std::vector<Pose2> result = {continued, pose_, halfway(pose_, continued)};
  if (const std::optional<double> turn = yawChangeSince(scan)) {
    // The gyro measures the rotation better than a motion model. At typical scan rates the smoothed
    // velocity is more accurate than the difference of two noisy poses. The guess without both is
    // the last one.
    const Pose2 predicted = movedWithVelocity(scan);
    const Pose2 turned(pose_.x, pose_.y, pose_.yaw + *turn);
    result = {predicted, turned, halfway(turned, predicted), continued};
  }
  if (const std::optional<Pose2> moved = odometryMotion(odom_T_base)) {
    result.insert(needsOdometry(scan) ? result.begin() : result.end(), pose_ * *moved);
  }
  if (const std::optional<Pose2> moved = filterMotionSince(scan)) {
    // If this guess fits poorly, the reason is rarely the guess. Two other guesses are enough.
    result.resize(2);
    result.insert(result.begin(), pose_ * *moved);
  } else if (isLongAgo(scan)) {
    result.insert(result.begin(), predict(scan, odom_T_base));
  }
  return result;
}

MatchRequest MotionModel::request(const Points& points, const PlanarScan& scan,
                                  const std::optional<Pose2>& odom_T_base) const {
  const double seconds = scan.time - time_;
  const bool has_turn = yawChangeSince(scan).has_value();
  const bool is_filtered = filterMotionSince(scan).has_value();
  const bool is_gap = carried_ || isGap(seconds);
  const PredictionError error = errorAt(scan, odom_T_base);
  MatchRequest result{points, pose_, initialGuesses(scan, odom_T_base)};
  result.trusted = is_filtered || (has_turn && integrated_acceleration_ &&
                                   scan.integrated_acceleration && seconds <= gap_s_);
  result.trusted &= lost_scans_ == 0 && !placed_ && error.position_m() < kAccurateM;
  const bool by_odometry = is_gap && odometryMotion(odom_T_base);
  result.yaw_error_rad = kSigmas * error.yaw_rad();
  result.yaw_known = (has_turn || is_filtered || by_odometry) && lost_scans_ < kTrustedLostScans &&
                     result.yaw_error_rad < near_window_.angular_rad;
  result.wide = isWide(error) && !result.prior;
  result.lost = lost_scans_ > 0 || (is_gap && isWide(error));
  result.lost_scans = lost_scans_;
  result.search_all_yaws = result.lost && !result.yaw_known;
  result.prior = priorAt(odom_T_base, scan);
  result.near = !result.lost && !result.prior && !result.trusted && !isWide(error);
  if (result.prior) result.last = result.prior->pose;
  if (is_gap || (result.wide && !result.prior)) result.last = result.initial_guesses.front();
  if (result.wide && !result.prior && !is_gap && !result.lost)
    result.turned_back_m = 2.0 * pose_.between(result.initial_guesses.front()).distance();
  if (result.lost) {
    const double distance =
        lost_scans_ > 0 ? kSpeedLimit * (scan.time - found_time_) : kSigmas * error.position_m();
    result.search_scale = std::clamp(1.0 + distance / wide_window_m_, 1.0, kMaxSearchScale);
    // Scans that did not fit are a sign of a blocked view, not of a long way.
    if (lost_scans_ == 0) result.moved_scale = result.search_scale;
  }
  result.plausible_m = std::max(kMinPlausibleM, kSpeedLimit * (scan.time - found_time_));
  if (placed_) result.plausible_m = std::numeric_limits<double>::infinity();
  return result;
}

bool MotionModel::isWide(const PredictionError& error) const {
  return kSigmas * error.position_m() > near_window_.linear_m ||
         kSigmas * error.yaw_rad() > near_window_.angular_rad;
}

bool MotionModel::isAfterGap(const PlanarScan& scan,
                             const std::optional<Pose2>& odom_T_base) const {
  return !placed_ && continued_.mayBeGap(scan.time - time_) && isWide(errorAt(scan, odom_T_base));
}

bool MotionModel::isOutOfReach(const PlanarScan& scan,
                               const std::optional<Pose2>& odom_T_base) const {
  return !placed_ && isGap(scan.time - time_) &&
         kSigmas * errorAt(scan, odom_T_base).position_m() > kMaxSearchScale * wide_window_m_;
}

double MotionModel::reach(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const {
  const double seconds = std::max(0.0, scan.time - time_);
  const std::optional<Pose2> measured = odometryMotion(odom_T_base);
  const double moved = measured ? measured->distance() : seconds * velocity_.norm();
  return moved + kSigmas * errorAt(scan, odom_T_base).position_m();
}

/// True if the last scan that was matched is much longer ago than usual.
bool MotionModel::isLongAgo(const PlanarScan& scan) const {
  return lost_scans_ == 0 && !placed_ && (carried_ || isGap(scan.time - time_));
}

/// The pose if the velocity stays constant. The gyro and the accelerometer measure its changes.
Pose2 MotionModel::movedWithVelocity(const PlanarScan& scan) const {
  const double seconds = std::clamp(scan.time - time_, 0.0, kMaxPredicted_s);
  const std::optional<double> turn = yawChangeSince(scan);
  const Eigen::Vector2d velocity = velocity_ + 0.5 * velocityChangeSince(scan);
  if (turn) {
    const Eigen::Vector2d place = pose_.translation() + seconds * velocity;
    return {place.x(), place.y(), pose_.yaw + *turn};
  }
  const double yaw = seconds * yaw_rate_;
  const Eigen::Vector2d place =
      pose_.translation() + seconds * (Eigen::Rotation2Dd(0.5 * yaw) * velocity);
  return {place.x(), place.y(), pose_.yaw + yaw};
}

Pose2 MotionModel::predict(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const {
  if (placed_) return pose_;
  if (const std::optional<Pose2> moved = filterMotionSince(scan)) return pose_ * *moved;
  if (const std::optional<Pose2> moved = odometryMotion(odom_T_base)) return pose_ * *moved;
  const Pose2 moved = movedWithVelocity(scan);
  if (!isOutOfReach(scan, odom_T_base)) return moved;
  // The last pose must be in the search window, too: most of the map is there.
  const double farthest = 0.5 * kMaxSearchScale * wide_window_m_;
  const double distance = pose_.between(moved).distance();
  return distance > farthest ? interpolate(pose_, moved, farthest / distance) : moved;
}

/// `odometry`: error of its motion since the last scan.
PredictionError MotionModel::errorAt(const PlanarScan& scan,
                                     const std::optional<Pose2>& odom_T_base,
                                     const MotionError& odometry) const {
  PredictedStep step;
  step.seconds = std::clamp(scan.time - time_, 0.0, kMaxErrorTime);
  step.source = predictionSourceOf(scan, odom_T_base);
  step.yaw_measured =
      step.source == PredictionSource::kOdometry || filterMotionSince(scan) || yawChangeSince(scan);
  if (step.source == PredictionSource::kOdometry) {
    step.motion = *odometryMotion(odom_T_base);
    step.odometry = odometry;
  }
  PredictionError result = error_;
  result.grow(step);
  return result;
}

/// Yaw change by the gyro since the last scan, rad. Nothing after a long time, or if the integrated
/// yaw was restarted.
std::optional<double> MotionModel::yawChangeSince(const PlanarScan& scan) const {
  const double seconds = scan.time - time_;
  if (!integrated_yaw_ || !scan.integrated_yaw || !(seconds <= kMaxPredicted_s))
    return std::nullopt;
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
  if (lost_scans_ > 0 || placed_ || !(seconds >= 0.0)) return std::nullopt;
  const PredictionSource source = predictionSourceOf(scan, odom_T_base);
  if (source == PredictionSource::kOdometry) return pose_ * *odometryMotion(odom_T_base);
  if (seconds > gap_s_ && isGap(seconds)) return std::nullopt;
  // The motion between two scans is noisy.
  return source == PredictionSource::kVelocity && seconds <= gap_s_
             ? movedWithVelocity(scan)
             : request.initial_guesses.front();
}

double MotionModel::secondsSince(const PlanarScan& scan) const {
  const double seconds = std::max(0.0, scan.time - time_);
  return isGap(seconds) ? std::min(seconds, gap_s_) : std::min(seconds, kMaxPredicted_s);
}

void MotionModel::move(const Pose2& found, const Pose2& predicted, bool lost,
                       const PlanarScan& scan) {
  const Pose2 next = !lost ? found : isUsable(predicted) ? predicted : pose_;
  updateVelocity(next, scan, lost);
  along_.setZero();
  // After a lost or predicted pose the step is a correction, too.
  if (lost || placed_ || carried_ || lost_scans_ > 0) {
    continued_.stop();
  } else {
    continued_.add(pose_.inverse() * next, scan.time - time_, odom_.has_value());
  }
  pose_ = next;
  lost_scans_ = lost ? lost_scans_ + 1 : 0;
  placed_ = carried_ = false;
}

/// The velocity is smoothed, because over one period of a 40 Hz laser the noise of the poses is as
/// large as the motion. The accelerometer gives changes without delay. While lost, the velocity is
/// kept.
void MotionModel::updateVelocity(const Pose2& next, const PlanarScan& scan, bool lost) {
  const double seconds = scan.time - time_, since_measured = scan.time - measured_time_;
  if (placed_ || !(seconds > 0.0) || seconds > kMaxPredicted_s) {
    velocity_.setZero();
    yaw_rate_ = 0.0;
    return;
  }
  const Eigen::Vector2d gained = velocityChangeSince(scan);
  if (lost) {
    velocity_ = scan.integrated_acceleration ? Eigen::Vector2d(velocity_ + gained)
                                             : Eigen::Vector2d::Zero();
    yaw_rate_ = 0.0;
    return;
  }
  const Pose2 expected = movedWithVelocity(scan);
  const double gain = 1.0 / (since_measured + kVelocityTime);
  const Eigen::Vector2d missed = next.translation() - expected.translation();
  velocity_ += gained + gain * missed + (along_gain_ - gain) * along_.dot(missed) * along_;
  yaw_rate_ += gain * normalizeAngle(next.yaw - pose_.yaw - seconds * yaw_rate_);
}

void MotionModel::setGainAlong(const Eigen::Vector2d& direction, double gain) {
  along_ = direction;
  along_gain_ = gain;
}

void MotionModel::carry(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  const Pose2 next = predict(scan, odom_T_base);
  if (!isUsable(next)) return;
  velocity_ += velocityChangeSince(scan);
  if (!yawChangeSince(scan)) velocity_ = Eigen::Rotation2Dd(next.yaw - pose_.yaw) * velocity_;
  pose_ = next;
  continued_.stop();
  carried_ = true;
}

void MotionModel::follow(const Pose2& pose, const PlanarScan& scan) {
  move(pose, pose, false, scan);
  measured_time_ = scan.time;
  carried_ = true;
}

void MotionModel::remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                           const std::optional<PredictionError>& error) {
  odom_ = odom_T_base;
  filter_pose_ = scan.predicted;
  integrated_yaw_ = scan.integrated_yaw;
  integrated_acceleration_ = scan.integrated_acceleration;
  error_ = error.value_or(PredictionError());
  if (!error) {
    if (has_match_) continued_.addInterval(scan.time - found_time_);
    has_match_ = true;
    found_time_ = measured_time_ = scan.time;
  }
  time_ = scan.time;
}

void MotionModel::setPose(const Pose2& map_T_base) {
  pose_ = map_T_base;
  continued_.stop();
  odom_.reset();
  filter_pose_.reset();
  integrated_yaw_.reset();
  velocity_.setZero();
  yaw_rate_ = 0.0;
  error_ = PredictionError();
  placed_ = true;
}

void MotionModel::setFound(const Pose2& map_T_base) {
  const Eigen::Rotation2Dd turn(map_T_base.yaw - pose_.yaw);
  velocity_ = turn * velocity_;
  along_ = turn * along_;
  pose_ = map_T_base;
  found_time_ = measured_time_ = time_;
  error_ = PredictionError();
  lost_scans_ = 0;
  carried_ = false;
}

}  // namespace kestrel
