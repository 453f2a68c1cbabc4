// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/mapping/lost_watch.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/pipeline/mapping_stage.h"
#include "kestrel_slam/pipeline/matched_pose.h"
#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/pipeline/slam_config.h"
#include "kestrel_slam/pipeline/waiting_queue.h"

namespace kestrel {

struct GaussianPose2;
struct GraphRecord;
class SubmapGraph;

/// Which data the pose filter exchanges with the projector and the mapper.
struct CouplingOptions {
  bool attitude = true;    ///< the projector uses its attitude, rates and specific force
  bool height = true;      ///< the projector uses its height
  bool prediction = true;  ///< the mapper uses its motion prediction in odom
  bool barometer = true;   ///< the filter uses barometer heights
  double match_s = 0.0;    ///< delay of the mapper's pose before it reaches the filter, s
};

/// Configuration of the interaction of projector, filter and mapper.
struct PipelineConfig {
  SlamConfig slam;
  PoseFilterConfig filter;
  bool use_filter = true;  ///< the pose filter runs
  CouplingOptions coupling;
  bool level = false;              ///< assume that the vehicle is level; do not use the IMU
  bool level_without_imu = false;  ///< the same only while the IMU fails; false: drop the scans
  double max_wait_s = 0.1;         ///< longest time that a scan waits for its attitude
  std::size_t queue_size = 20;     ///< scans that may wait for their attitude
};

/// A sweep for the pipeline.
struct PipelineScan {
  SweepData data;
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  std::optional<Pose2> odom_T_base;  ///< odometry at the scan's stamp
  std::optional<double> time;        ///< on a monotone time base, if already repaired, s
  std::size_t number = 0;            ///< chosen by the caller to identify the scan in events
};

/// A scan that was mapped.
struct MappedSweep {
  const PipelineScan& input;
  const ProjectedSweep& projected;
  const PlanarScan& scan;  ///< the scan that was matched
  const MapperResult& result;
  const MovingBeams* moving = nullptr;  ///< what moves, if it was kept out
};

/// A scan that could not be used.
struct DroppedSweep {
  const PipelineScan& input;
  std::string reason;   ///< short phrase for statistics
  std::string message;  ///< full sentence with values
};

/// The parts of the work of a pipeline.
enum class PipelineStage { kFilter, kProjection, kMapping, kGraph };
constexpr std::size_t kPipelineStages = 4;
const char* toString(PipelineStage stage);

/// Reason of the problem that the pose filter refuses the readings of the IMU (on_problem).
constexpr char kFilterRefusesImu[] = "filter: bad IMU";

/// Projector, pose filter and mapper, connected as on a vehicle. Messages are added in the order of
/// arrival. A scan waits until the attitude at its last beam is known. The pipeline does not read a
/// clock: `arrival` (s) is the arrival time of a message on the clock of the caller and must not
/// decrease. Deterministic, not thread-safe.
class Pipeline {
 public:
  /// Throws std::invalid_argument if a value of the configuration is out of range.
  explicit Pipeline(const PipelineConfig& config);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  void addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu, double arrival);
  /// Adds a range finder reading. `is_upright`: true if the reading is the vertical height, false
  /// if it is a distance along a tilted axis.
  void addRange(const HeightSample& sample, double arrival, bool is_upright = false);
  void addBarometer(const HeightSample& sample, double arrival);
  void addScan(PipelineScan scan, double arrival);
  /// Call this after the last message. Drops the scans that still wait and reports the reason.
  void finish();

  /// Sets the pose of the vehicle in map (`initialpose`). `covariance`: of (x, y, yaw), m² and
  /// rad².
  void setPose(const Pose2& map_T_base, const Eigen::Matrix3d& covariance);
  /// Deletes the map. The next scan starts a new map at `map_T_base`.
  void reset(const Pose2& map_T_base = Pose2());

  /// Continues an older flight: the next scan begins a new part of its graph. `map_T_base`: where
  /// the vehicle may be (SubmapGraph::beginPart); without it, nobody knows. Throws
  /// std::invalid_argument if there is no graph.
  void continueWith(GraphRecord record, const std::optional<GaussianPose2>& map_T_base);
  /// From now on the vehicle is only localized in this map, which does not change.
  void localizeIn(Submap map);

  const Mapper& mapper() const { return mapping_.mapper(); }
  /// Null if scans are matched against one map that grows.
  SubmapGraph* graph() { return graph_.get(); }
  const PoseFilter& filter() const { return filter_; }
  const ProjectionStage& projection() const { return projection_; }

  // Events.
  std::function<void(const MappedSweep&)> on_scan;
  std::function<void(const DroppedSweep&)> on_drop;
  std::function<void(const FilterOutput&)> on_filter;  ///< a new state of the filter
  std::function<void(PipelineStage)> on_stage;         ///< this part of the work begins
  /// Something is wrong with the IMU, the mountings or the filter: called once for each reason.
  /// `time`: of the newest message, s.
  std::function<void(const ImuFault&, double time)> on_problem;

 private:
  struct WaitingScan {
    PipelineScan scan;
    SweepTimes times;
    double arrival;
  };
  struct WaitingPose {
    double arrival;
    MatchedPose pose;
  };

  void startGraph();
  void begin(PipelineStage stage) const {
    if (on_stage) on_stage(stage);
  }
  void advance(double arrival);
  void deliverPoses();
  void updateFilter(const CheckedImu& reading);
  void processQueue();
  bool handle(const WaitingScan& waiting);
  void map(const PipelineScan& scan, bool level);
  void addToGraph(const PlanarScan& scan, MapperResult& result);
  void drop(const PipelineScan& scan, const std::string& reason, const std::string& message);
  void reportProblems();
  std::vector<ImuFault> problemsOfFilter();

  PipelineConfig config_;
  ImuCheck imu_check_;
  ProjectionStage projection_;
  PoseFilter filter_;
  MappingStage mapping_;
  LostWatch lost_;
  std::unique_ptr<SubmapGraph> graph_;
  WaitingQueue<WaitingScan> queue_;
  std::deque<WaitingPose> poses_;  ///< delayed poses that the filter will receive later
  double now_ = -std::numeric_limits<double>::infinity();
  bool finished_ = false;
  std::set<std::string> reported_;          ///< reasons of problems
  std::optional<double> filter_bad_since_;  ///< time since which the filter refuses the IMU, s
};

}  // namespace kestrel
