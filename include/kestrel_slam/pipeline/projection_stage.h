// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <variant>

#include "kestrel_slam/pipeline/filtered_motion.h"
#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/height_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

using SweepData = std::variant<LaserScan, PointCloud>;

double stampOf(const SweepData& data);  ///< as recorded, s
SweepTimes sweepTimes(const SweepData& data);

struct ProjectionStageConfig {
  ProjectorConfig projector;
  AttitudeConfig attitude;
  bool level = false;              ///< the vehicle is taken to be level; no attitude is needed
  bool level_without_imu = false;  ///< the same only while the IMU fails; else scans are dropped
  double max_wait_s = 0.1;         ///< longest time that a sweep waits for its attitude
};

/// What is to be done with a sweep now.
struct SweepDecision {
  enum Kind { kProject, kProjectLevel, kWait, kDrop } kind = kWait;
  std::string reason, message;  ///< of kDrop: a phrase for statistics, and a sentence
};

/// A projected sweep, and what it was projected with.
struct ProjectedSweep {
  Projection projection;
  bool level = false;     ///< no attitude was used
  bool filtered = false;  ///< the attitude of the pose filter was used
};

/// The scan projector together with all that it needs to know: attitude of IMU or pose filter,
/// height, velocity. The node of the projector and the pipeline run this object.
class ProjectionStage {
 public:
  /// Throws std::invalid_argument where the configuration's angles or corrections cannot be read.
  explicit ProjectionStage(const ProjectionStageConfig& config);

  /// False where the reading is not used.
  bool addImu(const CheckedImu& reading);
  /// A state of the pose filter. False where it is not used.
  bool addMotion(const FilteredMotion& motion);
  /// A reading of a range finder. `is_upright`: it is the height itself, not a distance along the
  /// base's z axis. False where it is not used.
  bool addRange(const HeightSample& sample, bool is_upright = false);
  /// Velocity of the vehicle in base_stabilized at `stamp` (s), m/s. The newest one is used.
  void addVelocity(double stamp, const Eigen::Vector2d& velocity);

  /// What to do with a sweep that has waited for `waited_s`. `now`: on the clock of the IMU's
  /// stamps, s.
  SweepDecision judge(const SweepTimes& times, double waited_s, double now) const;

  /// Projects a sweep. `level`: without an attitude.
  ProjectedSweep project(const SweepData& data, const Eigen::Isometry3d& base_T_laser, bool level);

  AttitudeTracker& tracker() { return tracker_; }
  const AttitudeTracker& tracker() const { return tracker_; }
  const FilteredMotionBuffer& motions() const { return motions_; }
  const HeightTracker& heights() const { return heights_; }
  const ProjectionStageConfig& config() const { return config_; }

 private:
  bool waitsForFilter(const SweepTimes& times, double waited_s) const;
  std::string uncovered(const SweepTimes& times) const;
  Eigen::Vector2d velocityAt(double time) const;

  ProjectionStageConfig config_;
  ScanProjector projector_;
  AttitudeTracker tracker_;
  FilteredMotionBuffer motions_;
  HeightTracker heights_;
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  double velocity_stamp_ = 0.0;
  const AttitudeBuffer* last_attitude_ = nullptr;  ///< of the last sweep that used one
};

}  // namespace kestrel
