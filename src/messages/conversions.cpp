// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/conversions.h"

#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/symmetric_axes.h"

namespace kestrel {
namespace {

// Limits standard deviations to 1e-5 ... 1e3 m (or rad). Values outside come from rounding or are
// meaningless.
constexpr double kMinVariance = 1e-10;
constexpr double kMaxVariance = 1e6;

Eigen::Matrix3d positiveDefinite(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d symmetric = 0.5 * (covariance + covariance.transpose());
  if (!symmetric.allFinite()) return kMaxVariance * Eigen::Matrix3d::Identity();
  const SymmetricAxes<3> solver = symmetricAxes(symmetric);
  const Eigen::Vector3d values = solver.eigenvalues.cwiseMax(kMinVariance).cwiseMin(kMaxVariance);
  const Eigen::Matrix3d& axes = solver.eigenvectors;
  const Eigen::Matrix3d result = axes * values.asDiagonal() * axes.transpose();
  return 0.5 * (result + result.transpose());  // exactly symmetric
}

}  // namespace

Pose2 toPose2(const geometry_msgs::Pose& pose) {
  const auto& q = pose.orientation;
  const double yaw =
      std::atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
  return {pose.position.x, pose.position.y, yaw};
}

Eigen::Isometry3d fromMessage(const geometry_msgs::Transform& message) {
  const auto& q = message.rotation;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  transform.translation() << message.translation.x, message.translation.y, message.translation.z;
  return transform;
}

Pose2 planarFromMessage(const geometry_msgs::Pose& message) {
  const Eigen::Vector3d p(message.position.x, message.position.y, message.position.z);
  const Eigen::Quaterniond q(message.orientation.w, message.orientation.x, message.orientation.y,
                             message.orientation.z);
  if (!p.allFinite() || !q.coeffs().allFinite()) {
    throw std::invalid_argument("the pose has a value that is not finite");
  }
  constexpr double kMinNorm = 1e-6;
  if (q.norm() < kMinNorm) {
    throw std::invalid_argument("the quaternion of the pose is zero; use w = 1 for no rotation");
  }
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = q.normalized().toRotationMatrix();
  transform.translation() = p;
  return toPose2(transform);
}

geometry_msgs::Pose toMessage(const Pose2& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation.z = std::sin(0.5 * pose.yaw);
  message.orientation.w = std::cos(0.5 * pose.yaw);
  return message;
}

geometry_msgs::Transform toTransformMessage(const Eigen::Isometry3d& transform) {
  const Eigen::Quaterniond q(transform.linear());
  geometry_msgs::Transform message;
  message.translation.x = transform.translation().x();
  message.translation.y = transform.translation().y();
  message.translation.z = transform.translation().z();
  message.rotation.x = q.x();
  message.rotation.y = q.y();
  message.rotation.z = q.z();
  message.rotation.w = q.w();
  return message;
}

geometry_msgs::Transform toTransformMessage(const Pose2& pose) {
  const geometry_msgs::Pose source = toMessage(pose);
  geometry_msgs::Transform message;
  message.translation.x = source.position.x;
  message.translation.y = source.position.y;
  message.rotation = source.orientation;
  return message;
}

geometry_msgs::PoseWithCovariance toMessage(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  constexpr std::size_t kSide = 6, kZ = 2, kRoll = 3, kPitch = 4;
  constexpr std::size_t kPlace[] = {0, 1, 5};  // indices of x, y and yaw
  geometry_msgs::PoseWithCovariance message;
  message.pose = toMessage(pose);
  const Eigen::Matrix3d planar = positiveDefinite(covariance);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      message.covariance[kSide * kPlace[row] + kPlace[column]] = planar(row, column);
    }
  }
  message.covariance[kSide * kZ + kZ] = kUnmeasuredHeightVariance;
  message.covariance[kSide * kRoll + kRoll] = kUnmeasuredTiltVariance;
  message.covariance[kSide * kPitch + kPitch] = kUnmeasuredTiltVariance;
  return message;
}

nav_msgs::OccupancyGrid toMessage(MapSnapshot map) {
  nav_msgs::OccupancyGrid message;
  message.info.resolution = static_cast<float>(map.resolution_m);
  message.info.width = static_cast<std::uint32_t>(map.width);
  message.info.height = static_cast<std::uint32_t>(map.height);
  message.info.origin.position.x = map.origin_x;
  message.info.origin.position.y = map.origin_y;
  message.info.origin.orientation.w = 1.0;
  message.data = std::move(map.cells);
  return message;
}

MapSnapshot fromMessage(const nav_msgs::OccupancyGrid& message) {
  constexpr double kRound = 1e6;  // 0.05 as float32 is 0.050000001
  constexpr std::int8_t kOccupiedFrom = 50;
  MapSnapshot map;
  const std::size_t cells = static_cast<std::size_t>(message.info.width) * message.info.height;
  if (message.data.size() != cells || !(message.info.resolution > 0.0F)) return map;
  map.resolution_m = std::round(static_cast<double>(message.info.resolution) * kRound) / kRound;
  map.origin_x = message.info.origin.position.x;
  map.origin_y = message.info.origin.position.y;
  map.width = static_cast<int>(message.info.width);
  map.height = static_cast<int>(message.info.height);
  for (const std::int8_t value : message.data) {
    map.cells.push_back(value < 0               ? MapSnapshot::kUnknown
                        : value < kOccupiedFrom ? MapSnapshot::kFree
                                                : MapSnapshot::kOccupied);
  }
  return map;
}

sensor_msgs::Range toRangeMessage(const ros::Time& stamp, const std::string& level_frame,
                                  double height_m, double max_height_m) {
  sensor_msgs::Range message;
  message.header.stamp = stamp;
  message.header.frame_id = level_frame;
  message.radiation_type = sensor_msgs::Range::INFRARED;
  message.max_range = static_cast<float>(max_height_m);
  message.range = static_cast<float>(height_m);
  return message;
}

sensor_msgs::PointCloud2 hitCloud(const PlanarScan& scan, const Pose2& map_T_base) {
  sensor_msgs::PointCloud2 cloud;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(scan.hitCount());
  cloud.is_dense = true;
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.hit) continue;
    const Eigen::Vector2f end = (map_T_base * ray.end.cast<double>().eval()).cast<float>();
    *x = end.x();
    *y = end.y();
    *z = 0.0F;
    ++x;
    ++y;
    ++z;
  }
  return cloud;
}

}  // namespace kestrel
