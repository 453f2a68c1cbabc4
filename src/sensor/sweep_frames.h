// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/projection.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// Where the sensor was at one moment of its sweep, seen from `base_stabilized` at the reference
/// time. Floats: a sweep's beams are projected by the hundred thousand a second.
struct SensorFrame {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f origin;  ///< of the sensor
};

/// The sensor's frame at a few times of a sweep, close enough that all between them is a straight
/// line: over one interval even a fast vehicle turns by less than 0.2 degrees.
class SweepFrames {
 public:
  /// `times` in s; `stamp` is the reference time.
  SweepFrames(const SweepTimes& times, double stamp, const Eigen::Isometry3d& base_T_sensor,
              const VehicleState& vehicle);

  std::size_t intervals() const { return frames_.size() - 1; }
  const SensorFrame& frame(std::size_t i) const { return frames_[i]; }

  /// The frame at a share of the whole sweep, 0 to 1.
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
  std::optional<Eigen::Vector2d> integrated_acceleration_;  ///< the same; see Attitude
  Eigen::Quaterniond attitude_ = Eigen::Quaterniond::Identity();
};

/// The vertical limits of the slice, relative to the plane of the base, m.
struct Slice {
  float lowest, highest;  ///< end points below or above are left out
  float floor;            ///< below this it is the floor; -inf: unknown
  float ceiling;          ///< above this it is the ceiling; +inf: unknown
};

/// `height_m`: of the base over the floor; `ceiling_m`: of the ceiling over the base; `laser_z`: of
/// the laser over the plane of the base, m.
Slice sliceOf(const ProjectorConfig& config, const std::optional<double>& height_m,
              const std::optional<double>& ceiling_m, float laser_z);

/// How far a beam from height `origin_z` that rises by `rise` a meter stays in the slice, m.
inline float lengthInSlice(const Slice& slice, float origin_z, float rise) {
  constexpr float kLevel = 1e-6F;
  constexpr float kFar = 1e9F;
  if (rise > kLevel) return (slice.highest - origin_z) / rise;
  if (rise < -kLevel) return (slice.lowest - origin_z) / rise;
  return kFar;
}

/// The reason not to project with these frames, or nothing.
std::optional<Projection> checkAttitude(const SweepFrames& frames, double stamp,
                                        const ProjectorConfig& config);

}  // namespace kestrel
