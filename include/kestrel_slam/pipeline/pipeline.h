// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/pipeline/mapping_stage.h"
#include "kestrel_slam/pipeline/matched_pose.h"
#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/pipeline/slam_config.h"
#include "kestrel_slam/pipeline/waiting_queue.h"

namespace kestrel {

/// What the pose filter gives to projector and mapper, and what it gets.
struct CouplingOptions {
  bool attitude = true;    ///< its attitude, rates and forces go to the projector
  bool height = true;      ///< its height goes to the projector
  bool prediction = true;  ///< its motion in odom goes to the mapper
  bool barometer = true;   ///< it gets the barometer's heights
  double match_s = 0.0;    ///< the mapper's pose reaches it so much later, s
};

/// How projector, filter and mapper work together.
struct PipelineConfig {
  SlamConfig slam;
  PoseFilterConfig filter;
  bool use_filter = true;  ///< the pose filter runs
  CouplingOptions coupling;
  bool level = false;              ///< the vehicle is taken to be level; the IMU is not used
  bool level_without_imu = false;  ///< the same only while the IMU fails; else scans are dropped
  double max_wait_s = 0.1;         ///< longest time that a scan waits for its attitude
  std::size_t queue_size = 20;     ///< scans that may wait for their attitude
};

/// A sweep for the pipeline.
struct PipelineScan {
  SweepData data;
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  std::optional<Pose2> odom_T_base;  ///< odometry at the scan's stamp
  std::optional<double> time;        ///< on a monotone time base, where it was repaired already, s
  std::size_t number = 0;            ///< of the caller: finds the scan again in an event
};

/// A scan that was mapped.
struct MappedSweep {
  const PipelineScan& input;
  const ProjectedSweep& projected;
  const PlanarScan& scan;  ///< as the mapper has seen it
  const MapperResult& result;
};

/// A scan that could not be used.
struct DroppedSweep {
  const PipelineScan& input;
  std::string reason;   ///< a phrase for statistics
  std::string message;  ///< a sentence with the values
};

/// Projector, pose filter and mapper, coupled as they run on a vehicle. Everything is added in the
/// order of arrival; scans wait for the attitude of their last beam. Knows no clock: `arrival` (s)
/// is the time at which a message came, on the clock of the caller, and never decreases.
/// Single-threaded and deterministic.
class Pipeline {
 public:
  /// Throws std::invalid_argument where the configuration is outside of its limits.
  explicit Pipeline(const PipelineConfig& config);
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  void addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu, double arrival);
  /// A range finder's reading. `is_upright`: it is the height itself, not a slanted distance.
  void addRange(const HeightSample& sample, double arrival, bool is_upright = false);
  void addBarometer(const HeightSample& sample, double arrival);
  void addScan(PipelineScan scan, double arrival);
  /// No more messages come: scans that still wait are dropped with their reason.
  void finish();

  /// Places the vehicle in map (`initialpose`). `covariance`: of (x, y, yaw), m² and rad².
  void setPose(const Pose2& map_T_base, const Eigen::Matrix3d& covariance);
  /// Forgets the map; the next scan starts a new one at `map_T_base`.
  void reset(const Pose2& map_T_base = Pose2());

  const Mapper& mapper() const { return mapping_.mapper(); }
  const PoseFilter& filter() const { return filter_; }
  const ProjectionStage& projection() const { return projection_; }

  // Events.
  std::function<void(const MappedSweep&)> on_scan;
  std::function<void(const DroppedSweep&)> on_drop;
  std::function<void(const FilterOutput&)> on_filter;  ///< a new state of the filter

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

  void advance(double arrival);
  void deliverPoses();
  void updateFilter(const CheckedImu& reading);
  void processQueue();
  bool handle(const WaitingScan& waiting);
  void map(const PipelineScan& scan, bool level);
  void drop(const PipelineScan& scan, const std::string& reason, const std::string& message);

  PipelineConfig config_;
  ImuCheck imu_check_;
  ProjectionStage projection_;
  PoseFilter filter_;
  MappingStage mapping_;
  WaitingQueue<WaitingScan> queue_;
  std::deque<WaitingPose> poses_;  ///< on their way to the filter
  double now_ = -std::numeric_limits<double>::infinity();
  bool finished_ = false;
};

}  // namespace kestrel
