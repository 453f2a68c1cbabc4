// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Whether a position is one that a vehicle can have: finite, and not absurdly far.
bool isUsable(const Pose2& pose);

/// The motion of the vehicle up to its last scan, and the prediction of where the next one was
/// taken (paper 002 eq. 5-6): from a pose filter, the velocity, the gyro's turn, the
/// accelerometer and the odometry, whatever of them there is.
class MotionModel {
 public:
  explicit MotionModel(const MapperConfig& config, const Pose2& map_T_base = Pose2());

  /// The pose of the last scan, or where setPose placed the vehicle: map_T_base.
  const Pose2& pose() const { return pose_; }
  const Eigen::Vector2d& velocity() const { return velocity_; }  ///< in map, smoothed, m/s
  double time() const { return time_; }                          ///< of the last scan, s

  /// Where to look for the next scan: the initial guesses of the match, best first, and how far to
  /// search. `points` must outlive the result.
  MatchRequest request(const Points& points, const PlanarScan& scan,
                       const std::optional<Pose2>& odom_T_base) const;

  /// What the prediction of the next scan stands on.
  PredictionSource predictionSourceOf(const PlanarScan& scan,
                                      const std::optional<Pose2>& odom_T_base) const;

  /// Where the motion alone leads, for the directions that the scan does not constrain; nothing
  /// after a gap, while lost, and where somebody placed the vehicle.
  std::optional<Pose2> motionPrediction(const MatchRequest& request, const PlanarScan& scan,
                                        const std::optional<Pose2>& odom_T_base) const;

  /// Seconds since the last scan, at most those after which motion says nothing.
  double secondsSince(const PlanarScan& scan) const;

  /// The vehicle was found at `found`, or is lost and stays at `predicted`.
  void move(const Pose2& found, const Pose2& predicted, bool lost, const PlanarScan& scan);

  /// Remembers the sensors' readings at `scan`: what the next scan's motion is measured from.
  void remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base, bool lost);

  /// Somebody says where the vehicle is: its motion up to here says nothing more.
  void setPose(const Pose2& map_T_base);

 private:
  std::optional<double> turnSince(const PlanarScan& scan) const;
  std::optional<Pose2> predictedSince(const PlanarScan& scan) const;
  Eigen::Vector2d gainedSpeed(const PlanarScan& scan) const;
  void updateVelocity(const Pose2& next, const PlanarScan& scan, bool unknown);

  double gap_s_;
  double wide_window_m_;
  Pose2 pose_;
  Pose2 motion_;                          ///< from the scan before the last one to the last one
  std::optional<Pose2> odom_;             ///< odom_T_base of the last scan
  std::optional<Pose2> predicted_;        ///< of a pose filter, at the last scan
  std::optional<double> integrated_yaw_;  ///< of the gyro, at the last scan, rad
  std::optional<Eigen::Vector2d>
      integrated_acceleration_;  ///< of the accelerometer, at the last scan
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  double time_ = 0.0;
  double found_time_ = 0.0;  ///< of the last scan that was not lost
  int lost_scans_ = 0;       ///< in a row
  bool placed_ = false;      ///< somebody said where the vehicle is: search around there
};

}  // namespace kestrel
