// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "fuzz/fuzz_input.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel::fuzz {

/// A pose without wrapping the yaw, which the constructor would do.
inline Pose2 anyPose(FuzzInput& input) {
  Pose2 pose;
  pose.x = input.any(-5.0, 5.0);
  pose.y = input.any(-5.0, 5.0);
  pose.yaw = input.any(-4.0, 4.0);
  return pose;
}

/// The ranges of a room of 6 m x 4 m, some of them replaced.
inline LaserScan anyLaserScan(FuzzInput& input, double stamp) {
  LaserScan scan;
  const int beams = input.below(256);
  scan.stamp = stamp;
  scan.angle_min = input.any(-3.2, 0.0);
  scan.angle_increment = input.any(-0.1, 0.1);
  scan.time_increment = input.any(0.0, 1e-3);
  scan.range_min = input.any(0.0, 0.5);
  scan.range_max = input.any(1.0, 40.0);
  for (int i = 0; i < beams; ++i) {
    const double angle = scan.angle_min + scan.angle_increment * i;
    const double wall = std::min(3.0 / std::abs(std::cos(angle)), 2.0 / std::abs(std::sin(angle)));
    scan.ranges.push_back(input.below(8) == 1 ? input.anyFloat(0.0, 40.0)
                                              : static_cast<float>(wall));
  }
  return scan;
}

inline PointCloud anyCloud(FuzzInput& input, double stamp) {
  PointCloud cloud;
  cloud.stamp = stamp;
  for (int points = input.below(200); points > 0; --points) {
    cloud.points.push_back({input.anyFloat(-20.0, 20.0), input.anyFloat(-20.0, 20.0),
                            input.anyFloat(-2.0, 2.0), input.anyFloat(-0.1, 0.1)});
  }
  return cloud;
}

inline PlanarScan anyPlanarScan(FuzzInput& input, double time) {
  PlanarScan scan;
  scan.stamp = scan.time = time;
  if (input.flag()) scan.integrated_yaw = input.any(-10.0, 10.0);
  if (input.flag()) scan.integrated_acceleration = {input.any(-9, 9), input.any(-9, 9)};
  if (input.flag()) scan.predicted = anyPose(input);
  const auto point = [&](double size) {
    const float x = input.anyFloat(-size, size);
    return Eigen::Vector2f(x, input.anyFloat(-size, size));
  };
  for (int rays = input.below(128); rays > 0; --rays) {
    const Eigen::Vector2f origin = input.below(4) == 1 ? point(0.2) : Eigen::Vector2f::Zero();
    scan.rays.push_back({origin, point(8.0), input.below(4) != 1, input.below(16) == 1});
  }
  return scan;
}

inline ImuSample anyImu(FuzzInput& input, double stamp) {
  ImuSample sample;
  sample.stamp = stamp;
  if (input.flag()) sample.world_R_imu = input.anyRotation();
  if (input.flag()) sample.angular_velocity = input.anyVector(2.0);
  if (input.flag()) {
    sample.linear_acceleration = input.anyVector(1.0);
    sample.linear_acceleration->z() += 9.81;
  }
  return sample;
}

/// Stamps that mostly go forward.
class FuzzClock {
 public:
  double next(FuzzInput& input) {
    constexpr int kKinds = 32;
    const int kind = input.below(kKinds);
    if (kind == kKinds - 1) return input.any(0.0, 1e10);
    if (kind == kKinds - 2) now_ += input.any(-10.0, 10.0);
    if (!std::isfinite(now_)) now_ = 0.0;
    return now_ += input.within(0.0, 0.05);
  }

 private:
  double now_ = 1000.0;
};

inline void checkResult(const MapperResult& result) {
  FUZZ_CHECK(result.pose.isFinite() && result.match.pose.isFinite());
  FUZZ_CHECK(result.covariance.allFinite() && result.motion_covariance.allFinite());
  FUZZ_CHECK(result.velocity.allFinite());
  for (int i = 0; i < 3; ++i) FUZZ_CHECK(result.covariance(i, i) >= 0.0);
}

inline void checkScan(const PlanarScan& scan) {
  FUZZ_CHECK(std::isfinite(scan.stamp) && std::isfinite(scan.time));
  for (const PlanarRay& ray : scan.rays) {
    FUZZ_CHECK(ray.origin.allFinite() && ray.end.allFinite());
  }
}

}  // namespace kestrel::fuzz
