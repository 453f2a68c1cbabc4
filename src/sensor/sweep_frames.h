// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/projection.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// Pose of the sensor at one time of its sweep, in `base_stabilized` at the reference time. Floats
/// for speed: hundreds of thousands of beams per second are projected.
struct SensorFrame {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f origin;  ///< position of the sensor, m
};

/// Poses of the sensor at some times of a sweep. They are close enough for linear interpolation: in
/// one interval even a fast vehicle turns by less than 0.2 degrees.
class SweepFrames {
 public:
  /// `times` in s; `stamp` is the reference time.
  SweepFrames(const SweepTimes& times, double stamp, const Eigen::Isometry3d& base_T_sensor,
              const VehicleState& vehicle);

  std::size_t intervals() const { return frames_.size() - 1; }
  const SensorFrame& frame(std::size_t i) const { return frames_[i]; }

  /// The interpolated frame at a share of the sweep, 0 to 1.
  SensorFrame at(float share) const;

  AttitudeError error() const { return error_; }
  double maxTilt() const { return max_tilt_; }
  std::optional<double> integratedYaw() const { return integrated_yaw_; }
  std::optional<Eigen::Vector2d> integratedAcceleration() const { return integrated_acceleration_; }
  /// stabilized_R_base at the reference time.
  const Eigen::Quaterniond& attitude() const { return attitude_; }

 private:
  void add(double time, double stamp, const Eigen::Isometry3d& base_T_sensor,
           const VehicleState& vehicle);

  std::vector<SensorFrame> frames_;
  AttitudeError error_ = AttitudeError::kNone;
  double max_tilt_ = 0.0;                                   ///< rad
  std::optional<double> integrated_yaw_;                    ///< at the reference time
  std::optional<Eigen::Vector2d> integrated_acceleration_;  ///< at the reference time; see Attitude
  Eigen::Quaterniond attitude_ = Eigen::Quaterniond::Identity();
};

/// Vertical limits of the slice, relative to the horizontal plane through the base, m.
struct Slice {
  float lowest, highest;  ///< end points below or above are not mapped
  float floor;            ///< end points below are on the floor, see exitOf(); -inf: unknown
  float ceiling;          ///< end points above are on the ceiling; +inf: unknown
};

/// `height_m`: of the base over the floor; `ceiling_m`: of the ceiling over the base; `laser_z`: of
/// the laser over the base; all in m.
Slice sliceOf(const ProjectorConfig& config, const std::optional<double>& height_m,
              const std::optional<double>& ceiling_m, float laser_z);

/// Where a beam leaves the slice, m along the beam.
struct SliceExit {
  float length;   ///< here it leaves the slice
  float surface;  ///< here it may be on the floor or the ceiling; inf: unknown
};

/// Floor and ceiling begin at half of their distance from the laser at the latest: an error of the
/// attitude (1 degree) raises them with the range. A beam that rises less than it falls stays.
///
/// `origin_z`: height of its origin, `rise`: vertical component of its unit direction.
inline SliceExit exitOf(const Slice& slice, float origin_z, float rise) {
  constexpr float kLevel = 1e-6F, kFar = 1e9F, kAttitudeError = 0.0175F;
  const float steepness = std::abs(rise);
  if (steepness <= kLevel) return {kFar, kFar};
  const bool down = rise < 0.0F;
  const float height = down ? origin_z - slice.floor : slice.ceiling - origin_z;
  const float surface = height * std::max(1.0F / (steepness + kAttitudeError), 0.5F / steepness);
  const float limit = ((down ? slice.lowest : slice.highest) - origin_z) / rise;
  return {std::min(limit, surface), surface};
}

/// A rejected projection if the attitude is missing or too tilted, else nothing.
std::optional<Projection> checkAttitude(const SweepFrames& frames, double stamp,
                                        const ProjectorConfig& config);

}  // namespace kestrel
