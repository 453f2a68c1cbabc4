// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "scan_validation.h"

namespace kestrel {
namespace {

constexpr double kInterval = 4e-3;       // s
constexpr double kMaxIntervals = 200.0;  // per sweep
constexpr float kClearance = 0.05F;      // m; smallest distance of the laser to floor and ceiling
constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace

SweepFrames::SweepFrames(const SweepTimes& times, double stamp,
                         const Eigen::Isometry3d& base_T_sensor, const VehicleState& vehicle) {
  Attitude reference;
  if (vehicle.attitude != nullptr) {
    error_ = vehicle.attitude->lookup(stamp, reference);
    if (error_ == AttitudeError::kNone) error_ = vehicle.attitude->covers(times.first, times.last);
    if (error_ != AttitudeError::kNone) return;
    integrated_yaw_ = reference.integrated_yaw;
    integrated_acceleration_ = reference.integrated_acceleration;
    attitude_ = reference.stabilized_R_base;
  }
  const bool moves =
      vehicle.attitude != nullptr || !vehicle.velocity.isZero() || vehicle.yaw_rate != 0.0;
  const double duration = times.last - times.first;
  const double intervals =
      moves ? std::clamp(std::ceil(duration / kInterval), 1.0, kMaxIntervals) : 1.0;
  const auto count = static_cast<std::size_t>(intervals);
  frames_.reserve(count + 1);
  for (std::size_t i = 0; i <= count; ++i) {
    const double share = static_cast<double>(i) / intervals;
    add(times.first + share * duration, stamp, base_T_sensor, vehicle);
  }
}

void SweepFrames::add(double time, double stamp, const Eigen::Isometry3d& base_T_sensor,
                      const VehicleState& vehicle) {
  Attitude attitude;
  double turned = vehicle.yaw_rate * (time - stamp);
  if (vehicle.attitude != nullptr) {
    vehicle.attitude->lookup(time, attitude);
    turned = attitude.integrated_yaw - *integrated_yaw_;
  }
  max_tilt_ = std::max(max_tilt_, tiltOf(attitude.stabilized_R_base));
  const Eigen::Quaterniond reference_R_base =
      Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitZ()) * attitude.stabilized_R_base;
  Eigen::Vector3d origin = reference_R_base * base_T_sensor.translation();
  origin.head<2>() += vehicle.velocity * (time - stamp);
  const Eigen::Matrix3d rotation = reference_R_base * base_T_sensor.linear();
  frames_.push_back({rotation.cast<float>(), origin.cast<float>()});
}

SensorFrame SweepFrames::at(float share) const {
  // The comparison is false for NaN, which is no index.
  const float inside = share > 0.0F ? std::min(share, 1.0F) : 0.0F;
  const float place = inside * static_cast<float>(intervals());
  const auto i = std::min(static_cast<std::size_t>(place), intervals() - 1);
  const float fraction = place - static_cast<float>(i);
  const SensorFrame &a = frames_[i], &b = frames_[i + 1];
  return {a.rotation + fraction * (b.rotation - a.rotation),
          a.origin + fraction * (b.origin - a.origin)};
}

Slice sliceOf(const ProjectorConfig& config, const std::optional<double>& height_m,
              const std::optional<double>& ceiling_m, float laser_z) {
  Slice slice{laser_z + static_cast<float>(config.slice_min_m),
              laser_z + static_cast<float>(config.slice_max_m), -kInfinity, kInfinity};
  const std::optional<double> height =
      !height_m && config.height_m > 0.0 ? config.height_m : height_m;
  const std::optional<double> ceiling =
      height && config.ceiling_m > 0.0 ? config.ceiling_m - *height : ceiling_m;
  // The limits keep a clearance to the laser, so that a vehicle on the ground or below the ceiling
  // still gets its horizontal beams.
  if (height) {
    slice.floor =
        std::min(static_cast<float>(config.floor_margin_m - *height), laser_z - kClearance);
  }
  if (ceiling) {
    slice.ceiling =
        std::max(static_cast<float>(*ceiling - config.floor_margin_m), laser_z + kClearance);
  }
  return slice;
}

std::optional<Projection> checkAttitude(const SweepFrames& frames, double stamp,
                                        const ProjectorConfig& config) {
  char text[120];
  if (frames.error() != AttitudeError::kNone) {
    std::snprintf(text, sizeof text, "no attitude for the scan at %.3f s: %s", stamp,
                  toString(frames.error()));
    return refused(ScanError::kNoAttitude, text);
  }
  if (frames.maxTilt() > config.max_tilt_rad) {
    std::snprintf(text, sizeof text, "the vehicle is tilted by %.1f deg, max_tilt allows %.1f deg",
                  radToDeg(frames.maxTilt()), radToDeg(config.max_tilt_rad));
    return refused(ScanError::kTilted, text);
  }
  return std::nullopt;
}

}  // namespace kestrel
