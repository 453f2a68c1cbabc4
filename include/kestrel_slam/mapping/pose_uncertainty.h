// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/map_uncertainty.h"
#include "kestrel_slam/matching/match_result.h"

namespace kestrel {

/// A pose and what is known of its error, as covariances of (x, y, yaw) in map, m² and rad².
struct UncertainPose {
  Pose2 pose;  ///< map_T_base
  Eigen::Matrix3d map_covariance =
      Eigen::Matrix3d::Zero();  ///< with all that is known from this place
  Eigen::Matrix3d match_covariance = Eigen::Matrix3d::Zero();  ///< of this one match
  Eigen::Matrix3d covariance() const {
    return map_covariance + match_covariance;
  }  ///< absolute: of the pose in map
};

/// Covariance of the motion a⁻¹ b, in the frame of `a`. The shared errors of two poses are taken
/// for one chain of which one of them has come farther: what both have cancels, whatever the way.
Eigen::Matrix3d relativeCovariance(const UncertainPose& a, const UncertainPose& b);

/// What tells the motion along a direction that the scan does not constrain.
enum class PredictionSource { kVelocity, kAccelerometer, kOdometry };

/// Follows the uncertainty of the pose from scan to scan: the match, the map it was matched to, and
/// the way along unconstrained directions, which adds up until a scan constrains them again.
class PoseUncertainty {
 public:
  /// The first scan defines the map at `pose`.
  void begin(const Pose2& pose);

  /// `match` was found `seconds` after the scan before, `moved_m` away from it; what it did not
  /// constrain was filled by `prediction_source`.
  void update(const SurfelField& surface, const Points& points, const MatchResult& match,
              double seconds, double moved_m, PredictionSource prediction_source);

  /// Nothing is known of the vehicle but its last pose and a prediction.
  void lose(const Pose2& predicted);

  /// The last scan enters the map.
  void insert();

  const UncertainPose& last() const { return last_; }
  const Eigen::Matrix3d& motion() const {
    return motion_;
  }  ///< since the scan before, in its frame

 private:
  void drift(double seconds, double moved_m, PredictionSource prediction_source);

  MapUncertainty map_;
  UncertainPose last_;
  Eigen::Matrix3d found_ = Eigen::Matrix3d::Zero();  ///< covariance of the last pose not lost
  Eigen::Matrix3d motion_ = Eigen::Matrix3d::Zero();
  bool drifting_ = false;  ///< the last scan left a direction open
  Eigen::Vector2d unobservable_direction_ =
      Eigen::Vector2d::Zero();   ///< that, a unit vector in map
  double entry_variance_ = 0.0;  ///< along it where the drift began, m²
  double drift_m_ = 0.0;         ///< standard deviation of the way since then,
  double drift_speed_ = 0.0;     ///< and of its speed now, m/s
};

}  // namespace kestrel
