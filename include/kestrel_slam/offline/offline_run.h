// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/offline/graph_result.h"
#include "kestrel_slam/offline/perturbation.h"
#include "kestrel_slam/pipeline/pipeline.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

class SubmapGraph;

/// State of the pose filter at a scan, for the report.
struct FilterSample {
  double height_m = 0.0;
  double tilt_rad = 0.0;
  double gyro_bias_rad_s = 0.0;          ///< size
  double accelerometer_bias_m_s2 = 0.0;  ///< size
};

/// What moved at a scan, for the report.
struct TrackerSample {
  double objects = 0.0;   ///< number of objects that are shown
  double kept_out = 0.0;  ///< share of the beams that are on them, 0 to 1
};

/// Data of one processed scan for the report.
struct ScanRecord {
  double time = 0.0;  ///< on the repaired time base, s
  MatchState state = MatchState::kLost;
  double score = 0.0;       ///< fit of the scan, 0 to 1
  double evaluation = 0.0;  ///< penalized score, f in [MAV SLAM 2013, eq. 4]
  double ms = 0.0;          ///< measured time of projection, match and insertion
  std::array<double, kPipelineStages> stage_ms{};  ///< the parts of it, by PipelineStage
  int iterations = 0;
  bool searched = false;
  bool inserted = false;
  std::size_t map_bytes = 0;  ///< memory of the map after the scan
  bool degenerate = false;    ///< true if an unobservable direction was taken from the prediction
  UncertainPose uncertain;    ///< the pose with its covariance
  double known = 0.0;         ///< share of the beams in known space, 0 to 1
  double constraint = 0.0;    ///< share of the points that constrain the weakest direction
  Eigen::Vector2d degenerate_direction =
      Eigen::Vector2d::Zero();       ///< in map; zero if there is none
  bool carried = false;              ///< there is no match: the pose is the prediction
  bool ambiguous = false;            ///< the scan fits in several places
  std::string reason;                ///< of the state, see reasonOf()
  std::optional<Pose2> odom_T_base;  ///< the odometry that was used
  std::optional<FilterSample> filter;
  std::optional<TrackerSample> tracker;  ///< if what moves is kept out
};

/// The complete result of one recording. `scans[i]` belongs to `trajectory[i]`.
struct OfflineRun {
  Trajectory trajectory;  ///< one pose per processed scan; for a lost scan, the predicted pose
  std::vector<ScanRecord> scans;
  std::map<std::string, std::size_t> dropped;        ///< scans that could not be used, by reason
  std::map<std::string, std::string> drop_messages;  ///< the first message of each reason, if any
  std::size_t left_out = 0;                          ///< scans that the perturbation removed
  std::vector<std::string> warnings;  ///< for the user; each problem is reported once
  double distance_m = 0.0;            ///< traveled
  double duration_s = 0.0;            ///< recorded
  double processing_s = 0.0;          ///< measured
  double peak_memory_mb = 0.0;        ///< measured, of the whole process
  std::size_t map_memory_bytes = 0;
  MapSnapshot map;
  std::optional<GraphResult> graph;    ///< if loops were searched for
  std::optional<Session> session;      ///< the same, with all that is needed to continue
  std::optional<FilterStatus> filter;  ///< status at the end; absent if the pose filter did not run

  std::size_t droppedCount() const;
  /// The most frequent reason why scans could not be used, with its numbers.
  std::string mainProblem() const;
  /// Recorded time divided by processing time. 0 if no time was measured.
  double speedFactor() const;
};

/// Which parts of a recording are used. Sensors that the recording does not have are ignored
/// without a warning.
struct RunOptions {
  bool use_odometry = false;
  Trajectory odometry;      ///< ascending stamps; replaces that of the recording; empty: none
  bool use_imu = true;      ///< use roll, pitch and yaw rate; false: assume a level vehicle
  bool use_filter = false;  ///< also run the pose filter, as on a vehicle; needs the IMU
  PoseFilterConfig filter;
  CouplingOptions coupling;
  std::optional<Eigen::Isometry3d> base_T_laser;  ///< replaces the mounting in the recording
  Perturbation perturbation;
  bool polish = false;  ///< match all scans once more with the finished map; needs the pose graph
  /// If there is one, the vehicle is only localized in this map, which is moved out. It begins at
  /// `start`, if that is known.
  std::shared_ptr<Submap> localize_in;
  std::size_t max_scans = std::numeric_limits<std::size_t>::max();  ///< number to process
  /// The older flight that is continued; null: none. Needs the pose graph.
  std::shared_ptr<const Session> session;
  std::optional<GaussianPose2> start;  ///< where the vehicle is in the map of `session`, if known
  /// Called for every scan that the mapper processed, with its result.
  std::function<void(const PlanarScan&, const MapperResult&)> observer;
  /// The same with everything that the pipeline knows of the scan, also its odometry.
  std::function<void(const MappedSweep&)> sweep_observer;
  /// Called for every state of the pose filter.
  std::function<void(const FilterOutput&)> filter_observer;
};

/// Progress of a run.
struct OfflineProgress {
  std::size_t done = 0;   ///< scans read so far
  std::size_t total = 0;  ///< scans in the recording
  double recorded_s = 0.0;
};

/// Called after every scan; returning false stops the run. Results up to this scan are kept.
using ProgressCallback = std::function<bool(const OfflineProgress&)>;

/// Maps the whole `recording`. The clock is only used to measure processing time. Therefore the
/// same recording and configuration give a bit-identical map and trajectory. If the recording ends
/// with a read error, the results up to this point are kept and a warning is added.
OfflineRun runOffline(Recording& recording, const SlamConfig& config,
                      const RunOptions& options = RunOptions(),
                      const ProgressCallback& progress = nullptr);

}  // namespace kestrel
