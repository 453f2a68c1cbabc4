// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/mapping/continued_motion.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/mapping/odometry_model.h"
#include "kestrel_slam/mapping/prediction_error.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Whether a pose is valid: finite, and not too far from the origin.
bool isUsable(const Pose2& pose);

/// What a pose says about the motion: nothing (it is a prediction), or it was matched; clearly in
/// every direction or not.
enum class MatchWorth { kNone, kMatched, kClear };

/// The motion of the vehicle up to the last scan, and the prediction of the next pose [Xie 2010,
/// eq. 5-6]. Uses what is available of: a pose filter, the velocity, the gyro, the accelerometer,
/// the odometry.
class MotionModel {
 public:
  explicit MotionModel(const MapperConfig& config, const Pose2& map_T_base = Pose2());

  /// map_T_base of the last scan, or the pose from setPose.
  const Pose2& pose() const { return pose_; }
  const Eigen::Vector2d& velocity() const {
    return velocity_;
  }                                             ///< in the map frame, smoothed, m/s
  double yawRate() const { return yaw_rate_; }  ///< smoothed, rad/s
  double time() const { return time_; }         ///< of the last scan, s

  /// The match request for the next scan: initial guesses, best first, and the size of the search
  /// windows. `points` must outlive the result.
  MatchRequest request(const Points& points, const PlanarScan& scan,
                       const std::optional<Pose2>& odom_T_base) const;

  /// The best prediction of the pose at `scan`, without a match.
  Pose2 predict(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  /// The error of `predict`, since the last match.
  PredictionError errorAt(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  /// setPose was called since the last scan: only an approximate pose is known.
  bool isPlaced() const { return placed_; }

  /// The last scan was not matched, and the pose was predicted.
  bool isCarried() const { return carried_; }

  /// True if the vehicle may be outside of the near search window around a prediction.
  bool isWide(const PredictionError& error) const;

  /// Whether scans are missing, or may be because their interval is unknown, and the
  /// prediction isWide.
  bool isAfterGap(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  /// Whether scans are missing for so long that the vehicle may be outside of the largest search
  /// window.
  bool isOutOfReach(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  /// How far the vehicle may be from pose() at `scan`, m: by its motion so far, and by the error of
  /// its continuation.
  double reach(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  /// The source of the motion prediction for the next scan.
  PredictionSource predictionSourceOf(const PlanarScan& scan,
                                      const std::optional<Pose2>& odom_T_base) const;

  /// The motion prediction for the next scan, used along unobservable directions. Nothing after a
  /// gap, while lost, and after setPose.
  std::optional<Pose2> motionPrediction(const MatchRequest& request, const PlanarScan& scan,
                                        const std::optional<Pose2>& odom_T_base) const;

  /// Seconds since the last scan; where scans are missing, at most the gap of the configuration.
  double secondsSince(const PlanarScan& scan) const;

  /// Updates the pose and the velocity: to `found`, or to `predicted` if lost.
  void move(const Pose2& found, const Pose2& predicted, bool lost, const PlanarScan& scan);

  /// Learns the errors of the odometry from the step to the pose `found`. `on_way_back`: it was
  /// found where only the reverse of the measured motion leads. To be called before move().
  void learnOdometry(const Pose2& found, const std::optional<Pose2>& odom_T_base, MatchWorth worth,
                     bool on_way_back = false);

  /// The vehicle may have driven back where the odometry measured a forward motion.
  bool mayBeReversed() const { return odometry_.sign().mayBeMissing(); }
  /// It is known not to measure the direction.
  bool isUnsigned() const { return odometry_.sign().isMissing(); }
  /// The last step was against the odometry.
  bool isReversed() const { return reversed_; }

  /// The next move() corrects the velocity along `direction` (a unit vector in the map frame) with
  /// this gain, 1/s, because there the position is mostly predicted.
  void setGainAlong(const Eigen::Vector2d& direction, double gain);

  /// Moves to the predicted pose at `scan`, which shows nothing to match.
  void carry(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);

  /// If nothing is known about the intervals of the laser, this is a typical one, s.
  void learnInterval(double seconds) { continued_.learnInterval(seconds); }

  /// Takes the typical interval of the laser from `other` if it is known there.
  void takeInterval(const MotionModel& other) { continued_.takeInterval(other.continued_); }

  /// In a map of its own, the vehicle goes on as `before` says, as seen from itself.
  void takeMotion(const MotionModel& before) {
    takeInterval(before);
    velocity_ = Eigen::Rotation2Dd(pose_.yaw - before.pose_.yaw) * before.velocity_;
    yaw_rate_ = before.yaw_rate_;
  }

  /// Whether scans are missing in this time since the last one, s.
  bool isGap(double seconds) const { return continued_.isGap(seconds); }

  /// Moves to the pose by the laser odometry; the scan at `scan` does not fit the map.
  void follow(const Pose2& pose, const PlanarScan& scan);

  /// Stores the sensor readings at `scan`, from which the motion to the next scan is computed.
  /// `error`: of a pose that is only predicted, since the last match; none if the scan was matched.
  void remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                const std::optional<PredictionError>& error);

  /// Sets the pose. The motion so far is not used for the next prediction.
  void setPose(const Pose2& map_T_base);
  /// The pose at the last scan is accurate. The vehicle moves on as before, as seen from itself.
  void setFound(const Pose2& map_T_base);

 private:
  std::vector<Pose2> initialGuesses(const PlanarScan& scan,
                                    const std::optional<Pose2>& odom_T_base) const;
  bool needsOdometry(const PlanarScan& scan) const;
  std::optional<MotionPrior> priorAt(const std::optional<Pose2>& odom_T_base,
                                     const PlanarScan& scan) const;
  PredictionError errorAt(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                          const MotionError& odometry) const;
  bool isLongAgo(const PlanarScan& scan) const;
  std::optional<Pose2> measuredMotion(const std::optional<Pose2>& odom_T_base) const;
  std::optional<Pose2> odometryMotion(const std::optional<Pose2>& odom_T_base) const;
  Pose2 movedWithVelocity(const PlanarScan& scan) const;
  std::optional<double> yawChangeSince(const PlanarScan& scan) const;
  std::optional<Pose2> filterMotionSince(const PlanarScan& scan) const;
  Eigen::Vector2d velocityChangeSince(const PlanarScan& scan) const;
  void updateVelocity(const Pose2& next, const PlanarScan& scan, bool lost);

  double gap_s_;
  SearchWindow near_window_;
  double wide_window_m_;
  Pose2 pose_;
  ContinuedMotion continued_;
  std::optional<Pose2> odom_;             ///< odom_T_base of the last scan
  std::optional<Pose2> filter_pose_;      ///< odom_T_base of a pose filter at the last scan
  std::optional<double> integrated_yaw_;  ///< integrated yaw of the gyro at the last scan, rad
  std::optional<Eigen::Vector2d> integrated_acceleration_;  ///< at the last scan, m/s
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d along_ = Eigen::Vector2d::Zero();  ///< direction with its own gain, or zero
  double along_gain_ = 0.0;                          ///< 1/s
  double yaw_rate_ = 0.0;                            ///< smoothed, rad/s
  PredictionError error_;                            ///< of the pose, since the last match
  OdometryModel odometry_;
  bool has_match_ = false;            ///< a scan was matched
  bool last_match_is_clear_ = false;  ///< the last scan was matched clearly in every direction
  bool reversed_ = false;             ///< the last step was against the odometry
  double time_ = 0.0;
  double found_time_ = 0.0;     ///< time of the last matched scan, s
  double measured_time_ = 0.0;  ///< time of the last pose that was not only predicted, s
  int lost_scans_ = 0;          ///< consecutive lost scans
  bool carried_ = false;  ///< the pose is predicted, because the last scan had nothing to match
  bool placed_ = false;   ///< setPose was called since the last scan
};

}  // namespace kestrel
