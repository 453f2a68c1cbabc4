// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// ok: the scan fits. degraded: it fits poorly, a direction is unobservable, it fits in two places,
/// or it does not fit and a good prediction carries the pose (odometry: always). lost: the scan
/// does not fit anywhere in the search windows and nobody knows the pose; it is the prediction.
enum class MatchState { kOk, kDegraded, kLost };

const char* toString(MatchState state);

/// Result for one scan.
struct MapperResult {
  Pose2 pose;  ///< map_T_base at the time of the scan; the prediction if lost
  /// Of (x, y, yaw) in the map frame, m² and rad².
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Covariance of the motion since the previous scan, in the base frame of the previous scan, m²
  /// and rad².
  Eigen::Matrix3d motion_covariance = Eigen::Matrix3d::Zero();
  UncertainPose uncertain;  ///< the parts of `covariance`, for relativeCovariance
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in the base frame, smoothed, m/s
  double yaw_rate = 0.0;                               ///< smoothed, rad/s
  MatchResult match;
  MatchState state = MatchState::kLost;
  const char* reason = "";  ///< of the state, see reasonOf()
  bool blank = false;       ///< too few hits for a match
  bool carried = false;     ///< there is no match: `pose` is the prediction, not a measurement
  std::optional<Pose2> odom_T_base;  ///< the odometry at the scan
  /// The motion since the last scan was against the odometry, which does not know the direction.
  bool reversed = false;
  /// After an impossible motion, until the state is ok again: the scan may have been matched with
  /// something that moves.
  bool doubtful = false;
  bool followed = false;    ///< the scan was matched with the scans before it, not with the map
  double evaluation = 0.0;  ///< f of [MAV SLAM 2013, eq. 4]: small if the scan fits
  bool inserted = false;    ///< the scan was inserted into the map
  /// Of an inserted scan:
  bool new_view = false;     ///< see OccupancyGrid::insert
  std::uint32_t submap = 0;  ///< number of the submap that it belongs to
  /// Covariance of the motion since the scan that was inserted before it, in the base frame of that
  /// scan, m² and rad².
  Eigen::Matrix3d keyframe_covariance = Eigen::Matrix3d::Zero();
  /// The part of it that all later poses keep, see PoseUncertainty::lastingSince().
  Eigen::Matrix3d lasting_covariance = Eigen::Matrix3d::Zero();
  bool searched = false;  ///< the local fit was poor and the exhaustive search was run
  /// The pose is a measurement of the scan.
  bool isMatched() const { return state != MatchState::kLost && !carried; }
  /// A part of this scan or of an earlier one was not inserted because of the memory limit.
  bool map_full = false;
};

/// Predict, match, evaluate, insert: one scan at a time, single-threaded and deterministic.
///
/// Uses neither a clock nor ROS. The first scan defines the map at the initial pose.
class Mapper {
 public:
  explicit Mapper(const MapperConfig& config);
  /// Localizes in a finished map, which never changes.
  Mapper(const MapperConfig& config, Submap map);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  /// Finds the pose of `scan`, and inserts the scan if the vehicle has moved enough and the fit is
  /// good. `odom_T_base`: odometry at the time of the scan, in any continuous frame; only its
  /// increments are used, except with known poses: then it is map_T_base. Does not throw. Rays and
  /// odometry that are not finite or too large are ignored. A scan without hits gives the predicted
  /// pose with its covariance.
  MapperResult process(const PlanarScan& scan,
                       const std::optional<Pose2>& odom_T_base = std::nullopt);

  /// Uses these thresholds and this matcher from the next scan on. Grid, window and the search
  /// windows stay as they were.
  void configure(const MapperConfig& config);

  /// Clears everything; the next scan starts a new map at `map_T_base`. A finished map is kept: the
  /// next scan is searched around `map_T_base`. Ignored if `map_T_base` is
  /// not finite or too large.
  void reset(const Pose2& map_T_base = Pose2());

  /// Sets the pose and keeps the map; the next scan is searched around `map_T_base`. Ignored if
  /// `map_T_base` is not finite or too large.
  void setPose(const Pose2& map_T_base);

  /// At its last scan, `measured` was at this pose, and it moves on as `measured` says. Unlike
  /// after setPose, the next scan is matched near its prediction only: that it fits in a second
  /// place nearby, too, says nothing against the pose.
  void setFoundPose(const Pose2& map_T_base, const Mapper& measured);

  /// Expects the scans of the same laser as `other`, as often: a gap is noticed from the first scan
  /// on.
  void takeInterval(const Mapper& other);

  /// Before the first scan, `scan`: the vehicle moves as it did in the map of `before`, as far as
  /// that is still known. Along a corridor, the first scans show no speed.
  void takeMotion(const Mapper& before, const PlanarScan& scan,
                  const std::optional<Pose2>& odom_T_base);

  /// If the interval of the laser is unknown, this is one of them, s.
  void learnInterval(double seconds);

  /// Whether scans are missing before `scan`, or may be because the interval is unknown, and the
  /// vehicle may have moved out of the near search window around the prediction meanwhile.
  bool isAfterGap(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  /// How far the vehicle may be from pose() at `scan`, m, see MotionModel::reach.
  double reach(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const;

  const Pose2& pose() const;
  const MapperConfig& config() const;
  /// What scans are matched against.
  const Submap& map() const;

  /// A copy of the map with the values {-1, 0, 100}.
  MapSnapshot snapshot() const;

  /// The changes for a copy of the map that another thread keeps (OccupancyGrid::takeChangedTiles).
  bool takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images);

  /// Memory of the maps, in bytes.
  std::size_t memoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
