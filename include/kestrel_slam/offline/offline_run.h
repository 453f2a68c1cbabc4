// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/offline/perturbation.h"
#include "kestrel_slam/pipeline/pipeline.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// What the report needs to know about one processed scan.
struct ScanRecord {
  double time = 0.0;  ///< on the repaired time base, s
  MatchState state = MatchState::kLost;
  double score = 0.0;       ///< fit of the scan, 0 to 1
  double evaluation = 0.0;  ///< f of paper 000 eq. 4
  double ms = 0.0;          ///< measured: projection, match and insertion
  int iterations = 0;
  bool searched = false;
  bool inserted = false;
  std::size_t map_bytes = 0;  ///< memory of the map after the scan
  bool degenerate = false;    ///< a direction was filled from the prediction
  UncertainPose uncertain;    ///< the pose with its covariance
};

/// Everything that came out of a recording. `scans[i]` belongs to `trajectory[i]`.
struct OfflineRun {
  Trajectory trajectory;  ///< one pose for every processed scan; of a lost one, the prediction
  std::vector<ScanRecord> scans;
  std::map<std::string, std::size_t> dropped;  ///< scans that could not be used, by reason
  std::size_t left_out = 0;                    ///< scans that the perturbation left out
  std::vector<std::string> warnings;           ///< sentences for the user, each problem once
  double distance_m = 0.0;                     ///< traveled
  double duration_s = 0.0;                     ///< recorded
  double processing_s = 0.0;                   ///< measured
  double peak_memory_mb = 0.0;                 ///< measured, of the whole process
  std::size_t map_memory_bytes = 0;
  MapSnapshot map;
  std::optional<FilterStatus> filter;  ///< at the end, where the pose filter ran

  std::size_t droppedCount() const;
  /// Recorded time over processing time; 0 where nothing was measured.
  double speedFactor() const;
};

/// Which parts of a recording are used; sensors that it does not have are never missed.
struct RunOptions {
  bool use_odometry = false;
  bool use_imu = true;  ///< roll, pitch and turn rate; without: the vehicle is taken to be level
  bool use_filter = false;  ///< the pose filter runs beside, as on a vehicle; needs the IMU
  PoseFilterConfig filter;
  CouplingOptions coupling;
  std::optional<Eigen::Isometry3d> base_T_laser;  ///< in place of what the recording says
  Perturbation perturbation;
  std::size_t max_scans = std::numeric_limits<std::size_t>::max();  ///< only the first so many
  /// Sees every scan that the mapper processed, and what became of it.
  std::function<void(const PlanarScan&, const MapperResult&)> observer;
  /// Sees every state of the pose filter.
  std::function<void(const FilterOutput&)> filter_observer;
};

/// How far a run has come.
struct OfflineProgress {
  std::size_t done = 0;   ///< scans read so far
  std::size_t total = 0;  ///< scans in the recording
  double recorded_s = 0.0;
};

/// Called after every scan; false stops the run, which then keeps what has been done.
using ProgressCallback = std::function<bool(const OfflineProgress&)>;

/// Maps `recording` from its start to its end. The clock is only read, never acted upon: the same
/// recording and configuration give the same map and trajectory, bit for bit. A recording that
/// breaks off midway keeps what came before, with a warning.
OfflineRun runOffline(Recording& recording, const SlamConfig& config,
                      const RunOptions& options = RunOptions(),
                      const ProgressCallback& progress = nullptr);

}  // namespace kestrel
