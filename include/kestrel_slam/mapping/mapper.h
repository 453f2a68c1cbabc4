// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// ok: the scan fits; degraded: it fits poorly or a direction is unconstrained; lost: it fits
/// nowhere within the search windows, the pose is the prediction.
enum class MatchState { kOk, kDegraded, kLost };

const char* toString(MatchState state);

/// What happened to one scan.
struct MapperResult {
  Pose2 pose;  ///< map_T_base at the scan's time (the prediction where lost)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw) in map, m² and rad²
  /// Of the motion since the scan before, in the base frame of that, m² and rad².
  Eigen::Matrix3d motion_covariance = Eigen::Matrix3d::Zero();
  UncertainPose uncertain;  ///< `covariance` in its parts, for relativeCovariance
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in base, smoothed, m/s
  MatchResult match;
  MatchState state = MatchState::kLost;
  double evaluation = 0.0;  ///< f of paper 000 eq. 4: small is good
  bool inserted = false;    ///< the scan entered the map
  bool searched = false;    ///< the local fit was bad and the exhaustive search ran
  bool map_full = false;    ///< the memory limit kept part of the scan out of the map
};

/// Predict, match, judge, insert: one scan at a time, single-threaded and deterministic.
///
/// Knows no clock and no ROS. The first scan defines the map at the start pose.
class Mapper {
 public:
  explicit Mapper(const MapperConfig& config);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  /// Finds the pose of `scan` and inserts it into the map where the vehicle moved enough and the
  /// fit is good. `odom_T_base` is the odometry at the scan's time, in any continuous frame; only
  /// its increments are used. Throws nothing: rays and odometry that are not finite, or farther
  /// away than any sensor sees, are left out; a scan without hits gives the last pose, kLost.
  MapperResult process(const PlanarScan& scan,
                       const std::optional<Pose2>& odom_T_base = std::nullopt);

  /// Forgets everything; the next scan starts a new map at `map_T_base`. Ignored where that is not
  /// finite, as in setPose.
  void reset(const Pose2& map_T_base = Pose2());

  /// Keeps the map and places the vehicle; the next scan is searched for around `map_T_base`.
  void setPose(const Pose2& map_T_base);

  const Pose2& pose() const;
  const MapperConfig& config() const;

  /// A copy of the map as {-1, 0, 100}.
  MapSnapshot snapshot() const;

  /// Memory of the maps, in bytes.
  std::size_t memoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
