// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kestrel_slam/pipeline/filtered_motion.h"
#include "kestrel_slam/pipeline/mounting_check.h"
#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/height_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

using SweepData = std::variant<LaserScan, PointCloud>;

double stampOf(const SweepData& data);  ///< as recorded, s
const std::string& frameOf(const SweepData& data);
SweepTimes sweepTimes(const SweepData& data);

struct ProjectionStageConfig {
  ProjectorConfig projector;
  AttitudeConfig attitude;
  bool level = false;              ///< assume that the vehicle is level; no attitude is needed
  bool level_without_imu = false;  ///< the same only while the IMU fails; false: drop the scans
  double max_wait_s = 0.1;         ///< longest time that a sweep waits for its attitude
};

/// What to do with a sweep now.
struct SweepDecision {
  enum Kind { kProject, kProjectLevel, kWait, kDrop } kind = kWait;
  std::string reason, message;  ///< for kDrop: short phrase for statistics, full sentence
};

/// A projected sweep and the source of its attitude.
struct ProjectedSweep {
  Projection projection;
  bool level = false;     ///< no attitude was used
  bool filtered = false;  ///< the attitude of the pose filter was used
};

/// The scan projector and its inputs: attitude from the IMU or the pose filter, height, and
/// velocity. Both the projector node and the pipeline use this class.
class ProjectionStage {
 public:
  /// Throws std::invalid_argument if the angles or corrections of the configuration cannot be
  /// parsed.
  explicit ProjectionStage(const ProjectionStageConfig& config);

  /// See ScanProjector::configure.
  void configure(const ProjectorConfig& config) { projector_.configure(config); }

  /// Returns false if the reading is not used.
  bool addImu(const CheckedImu& reading);
  /// Adds a state of the pose filter. Returns false if it is not used.
  bool addMotion(const FilteredMotion& motion);
  /// Adds a range finder reading. `is_upright`: true if the reading is the vertical height, false
  /// if it is a distance along the z axis of the base. Returns false if it is not used.
  bool addRange(const HeightSample& sample, bool is_upright = false);
  /// Sets the velocity of the vehicle in base_stabilized at `stamp` (s), m/s, and its yaw rate,
  /// rad/s. Only the newest ones are used, and the yaw rate only without an IMU.
  void addVelocity(double stamp, const Eigen::Vector2d& velocity, double yaw_rate);

  /// Decides what to do with a sweep that has waited for `waited_s`. `now`: current time on the
  /// clock of the IMU stamps, s.
  SweepDecision judge(const SweepTimes& times, double waited_s, double now) const;

  /// Projects a sweep. `level`: assume that the vehicle is level. `odom_T_base`: odometry at its
  /// stamp, only to check the mounting of the laser.
  ProjectedSweep project(const SweepData& data, const Eigen::Isometry3d& base_T_laser, bool level,
                         const std::optional<Pose2>& odom_T_base = std::nullopt);

  /// What is wrong with the IMU and the mountings, for the user: each problem with its reason (a
  /// short phrase) and a sentence. `now`: current time on the clock of the IMU stamps, s.
  std::vector<ImuFault> problems(double now) const;
  /// True if the scans show that the gyro is in degrees per second (ImuCheck::convertGyro).
  bool gyroInDegrees() const { return mountings_.gyroInDegrees(); }

  AttitudeTracker& tracker() { return tracker_; }
  const AttitudeTracker& tracker() const { return tracker_; }
  const FilteredMotionBuffer& motions() const { return motions_; }
  const HeightTracker& heights() const { return heights_; }

 private:
  struct IntegralOffset {
    double yaw = 0.0;                                    ///< rad
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< m/s
  };
  /// The integrals of the last scan, as given to the mapper.
  struct Integrals {
    double stamp, yaw;
    std::optional<Eigen::Vector2d> velocity;
  };

  void continueIntegrals(const AttitudeBuffer& attitude, PlanarScan& scan);
  std::optional<IntegralOffset> offsetTo(const AttitudeBuffer& attitude,
                                         const PlanarScan& scan) const;
  static IntegralOffset offsetBetween(double yaw, const std::optional<Eigen::Vector2d>& velocity,
                                      double given_yaw,
                                      const std::optional<Eigen::Vector2d>& given_velocity);
  void checkMounting(const SweepData& data, const Eigen::Isometry3d& base_T_laser,
                     const std::optional<Pose2>& odom_T_base);
  bool waitsForFilter(const SweepTimes& times, double waited_s) const;
  std::string uncovered(const SweepTimes& times) const;
  VehicleState vehicleAt(double time, const AttitudeBuffer* attitude) const;

  ProjectionStageConfig config_;
  ScanProjector projector_;
  AttitudeTracker tracker_;
  FilteredMotionBuffer motions_;
  HeightTracker heights_;
  MountingCheck mountings_;
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  double yaw_rate_ = 0.0;  ///< rad/s
  double velocity_stamp_ = 0.0;
  const AttitudeBuffer* last_attitude_ = nullptr;  ///< used for the last sweep
  IntegralOffset integral_offset_;
  std::optional<Integrals> last_integrals_;
};

}  // namespace kestrel
