// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/mapping/prediction_error.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

class Mapper;
class MotionModel;
class PoseUncertainty;
struct MapperResult;

/// The motion of the vehicle from scans alone, for scans that do not fit the map: each is matched
/// with the scans before it, in a map of their own.
class LaserOdometry {
 public:
  explicit LaserOdometry(const MapperConfig& config);
  ~LaserOdometry();
  LaserOdometry(LaserOdometry&&) noexcept;
  LaserOdometry& operator=(LaserOdometry&&) noexcept;

  /// The motion is measured from this scan on. `is_matched`: its pose was found in the map.
  void begin(const PlanarScan& scan, const Pose2& map_T_base, bool is_matched);

  /// Forgets all scans, for example because the last one shows nothing.
  void stop();

  /// Matches a scan with those since begin(). Returns false if it does not fit them.
  bool follow(const PlanarScan& scan);

  /// map_T_base of the last scan, or its prediction if it was not matched.
  const Pose2& pose() const { return pose_; }
  /// The error of the motion since begin().
  const PredictionError& error() const { return error_; }

  /// For a scan that does not fit the map. If it fits the scans before it, this moves the vehicle,
  /// fills the state, and returns true. Not with an odometry, which is better. `predicted`: the
  /// error of the prediction by `source`. The state is
  ///  - degraded (carried), if the motion from the last match to this scan is known well enough;
  ///  - lost otherwise. The pose is then relative to an unknown place.
  bool carry(const PlanarScan& scan, PredictionSource source, const PredictionError& predicted,
             MotionModel& motion, PoseUncertainty& uncertainty, MapperResult& result);

  /// False if the match with the map is far from the prediction, and in the scan before, alone,
  /// another motion explains the scan better or nearly as well. Then one may be wrong: this match
  /// with the map, or those before.
  bool agrees(const MatchRequest& request, const MatchResult& found) const;

  /// The error of the pose of a scan that was not matched with the map, since the last match. It is
  /// that of the motion that the scans show, or else `predicted`. Nothing for a match.
  std::optional<PredictionError> errorAfter(const MapperResult& result,
                                            const PredictionError& predicted) const;

  /// To be called last for every scan, with its result and pose.
  void update(const PlanarScan& scan, const MapperResult& result, const Pose2& map_T_base);

  /// Memory of the map of these scans, in bytes.
  std::size_t memoryBytes() const;

 private:
  MapperConfig config_;
  std::unique_ptr<Mapper> mapper_;  ///< of the scans since begin(); created when it is needed
  std::optional<PlanarScan> first_scan_;
  Pose2 first_pose_, pose_;
  PredictionError error_;
  bool begins_at_match_ = false;  ///< and all scans since then fit
};

}  // namespace kestrel
