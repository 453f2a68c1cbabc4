// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker_config.h"
#include "kestrel_slam/lidar/surface_map.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {

/// An object that a 3D lidar follows, in the frame of the map.
struct CloudTrack {
  Track plane;                     ///< seen from above
  double z = 0.0, climb = 0.0;     ///< of its middle, m and m/s
  double bottom = 0.0, top = 0.0;  ///< of its visible points, m

  /// Sweeps are slow: a track without observations is shown for two of them.
  bool isShown() const { return plane.isShown() && plane.unseen_s < 0.25; }
};

/// One sweep of a 3D lidar.
struct LidarSweep {
  PointCloud cloud;
  /// Unit vectors of the beams without return, in the frame of the lidar [Siew 2018, sec. V: dummy
  /// points]. Empty: not known, and the visitation grid is used.
  std::vector<Eigen::Vector3f> unanswered;
};

/// Localization, mapping and tracking of moving objects with a 3D lidar alone [Siew 2018]: ground
/// removal, ICP against the static map, static and dynamic voxel grid, clusters, PHD filter,
/// tracks. Deterministic; uses no clock; bounded work and memory.
class CloudTracker {
 public:
  explicit CloudTracker(const CloudTrackerConfig& config = CloudTrackerConfig());
  ~CloudTracker();
  CloudTracker(CloudTracker&&) noexcept;
  CloudTracker& operator=(CloudTracker&&) noexcept;

  struct Result {
    bool used = false;    ///< false: the sweep cannot be used, nothing has changed
    std::string problem;  ///< why, and what to do; also says what limits a sweep that is used
    /// False: the pose is only predicted, because there are too few surfaces, or because they do
    /// not fit to the map anywhere near. In the second case there are no tracks and no moving
    /// points, and the maps do not change; after a second, maps and tracks start anew.
    bool localized = false;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< map_T_lidar at the stamp
    std::vector<CloudTrack> tracks;  ///< all, also those that do not move, by rising id
    /// Of each point of the cloud: true if it belongs to an object that moves.
    std::vector<bool> moving;
    std::vector<bool> ground;  ///< of each point of the cloud
    bool saturated = false;    ///< a bound on the work was reached; something may be missing
  };

  /// Adds a sweep. `predicted`: map_T_lidar, for example from a pose filter; without it, the motion
  /// goes on as it was. Sweeps that are not newer than the last one are refused. After a gap of
  /// 5 s, maps and tracks start anew. Valid until the next call.
  const Result& process(const LidarSweep& sweep,
                        const std::optional<Eigen::Isometry3d>& predicted = std::nullopt);

  const Eigen::Isometry3d& pose() const;  ///< map_T_lidar of the last sweep that was used
  std::optional<double> stamp() const;    ///< of this sweep, s
  const SurfaceMap& surfaces() const;
  const MotionGrid<3>& grid() const;
  /// Of both maps.
  std::size_t memoryBytes() const;
  /// Forgets everything; track ids go on.
  void reset();

 private:
  void startAnew();

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
