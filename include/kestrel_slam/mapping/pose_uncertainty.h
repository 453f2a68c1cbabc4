// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/map_uncertainty.h"
#include "kestrel_slam/mapping/prediction_error.h"
#include "kestrel_slam/matching/match_result.h"

namespace kestrel {

/// A pose and the parts of its covariance, of (x, y, yaw) in the map frame, m² and rad².
struct UncertainPose {
  Pose2 pose;  ///< map_T_base
  /// Uncertainty of the map at this place, common to all poses here.
  Eigen::Matrix3d map_covariance = Eigen::Matrix3d::Zero();
  /// Of this match, independent of other matches.
  Eigen::Matrix3d match_covariance = Eigen::Matrix3d::Zero();
  /// The absolute covariance, in the map frame.
  Eigen::Matrix3d covariance() const { return map_covariance + match_covariance; }
};

/// Covariance of the motion a⁻¹ b, in the frame of `a`. The map errors of both poses are assumed to
/// come from the same chain of scans, so that the common error cancels.
Eigen::Matrix3d relativeCovariance(const UncertainPose& a, const UncertainPose& b);

/// The same errors at a pose to which the vehicle was moved together with its map.
UncertainPose placedAt(const Pose2& pose, const UncertainPose& uncertain);

/// A direction is weak if a smaller share of the beams shows it.
constexpr double kWeakConstraint = 0.02;

/// Error of the position and of the speed along an unobservable direction, relative to the map
/// around the vehicle.
struct AlongError {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (position, speed), m and m/s

  /// Extends the error by a step of `seconds` and `moved_m` that is only predicted.
  void predict(double seconds, double moved_m, PredictionSource source);
  /// The scan shows the position with `variance`, m².
  void correct(double variance, PredictionSource source);
  /// The error of the speed is not larger than this standard deviation.
  void limitSpeed(double sigma_m_s);
  /// Correction of the speed for each meter by which the position is corrected, 1/s.
  double speedGain() const {
    return covariance(0, 0) > 0.0 ? covariance(0, 1) / covariance(0, 0) : 0.0;
  }
};

/// Tracks the uncertainty of the pose from scan to scan: the match covariance, the map covariance,
/// and the drift along an unobservable direction, which grows until the direction is observable
/// again.
class PoseUncertainty {
 public:
  /// The first scan defines the map at `pose`.
  void begin(const Pose2& pose);

  /// Updates with `match`, found `seconds` after the previous scan and `moved_m` away from it.
  /// Along an unobservable direction the motion is from `prediction_source`.
  void update(const SurfelField& surface, const Points& points, const MatchResult& match,
              double seconds, double moved_m, PredictionSource prediction_source);

  /// The scan has nothing to match: the pose is `predicted`, with `error` since the last match.
  void carry(const Pose2& predicted, const PredictionError& error);

  /// The last position may be wrong by this error, although it was matched.
  void doubt(const PredictionError& error);

  /// The vehicle is lost; only a predicted pose is known.
  void lose(const Pose2& predicted, const PredictionError& error);

  /// The speed has this standard deviation, because nothing measured it yet, m/s.
  void setSpeedError(double sigma_m_s);
  /// Standard deviation of the speed in the direction in which it is known least, m/s.
  double speedError() const;

  /// The last scan was inserted into the map.
  void insert();
  /// Covariance of the motion since `inserted`, the pose of the last inserted scan.
  Eigen::Matrix3d motionSince(const UncertainPose& inserted) const;
  /// The part of it that all later poses keep: the growth of the error of the map. The error of a
  /// match does not last: it is in the motion to the scan and, with the other sign, in that from
  /// it.
  Eigen::Matrix3d lastingSince(const UncertainPose& inserted) const;

  /// The error along the unobservable direction of `match`, as predicted `seconds` after the last
  /// scan and `moved_m` away from it.
  AlongError alongError(const MatchResult& match, double seconds, double moved_m,
                        PredictionSource source) const;
  /// How far the vehicle may have moved since the last insertion, as a standard deviation along an
  /// unobservable direction, m.
  double driftSinceInsertion() const;

  const UncertainPose& last() const { return last_; }
  /// Covariance of the motion since the previous scan, in its base frame.
  const Eigen::Matrix3d& motion() const { return motion_; }

 private:
  void predict(const Pose2& predicted, const Eigen::Vector3d& sigmas);
  AlongError firstError(const Eigen::Vector2d& along, PredictionSource source) const;
  void drift(double seconds, double moved_m, PredictionSource source, double along_variance);

  MapUncertainty map_;
  UncertainPose last_;
  /// The last matched pose, and its covariance.
  Pose2 found_pose_;
  Eigen::Matrix3d found_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d motion_ = Eigen::Matrix3d::Zero();
  bool clear_ = false;              ///< the last scan showed the pose in all directions,
  bool followed_ = false;           ///< and so did all since the last insertion
  bool drifting_ = false;           ///< the last scan had an unobservable direction
  bool weak_ = false;               ///< the last scan had a weak direction, with the error along_
  double entry_variance_ = 0.0;     ///< variance along it at the beginning of the drift, m²
  double drift_variance_ = 0.0;     ///< variance of the motion since then, m²
  double inserted_variance_ = 0.0;  ///< the same at the last insertion
  AlongError along_;
  /// The same without what the scans show along it: a few beams do not show it for certain. This is
  /// what the pose claims without a motion sensor.
  AlongError drifted_;
  double base_variance_ = 0.0;  ///< variance of the map along it when the direction became weak, m²
  /// Of the speed, where it was only predicted, m/s. Zero: the smallest is assumed.
  double unmeasured_speed_m_s_ = 0.0;
};

}  // namespace kestrel
