// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/sensor_messages.h"

#include <cstdio>
#include <cstdlib>
#include <limits>

#include "kestrel_slam/sensor/point_buffer.h"

namespace kestrel {
namespace {

/// sensor_msgs/Imu: a covariance that begins with -1 marks a value as missing.
template <typename Covariance>
bool exists(const Covariance& covariance) {
  constexpr double kAbsent = -1.0;
  return covariance[0] != kAbsent;
}

Eigen::Vector3d toVector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

}  // namespace

double toSeconds(const ros::Time& time) {
  // Converts through text, because sec + 1e-9 * nsec rounds twice. Its last bit can differ from the
  // value in a log file.
  char text[32];
  std::snprintf(text, sizeof text, "%u.%09u", time.sec, time.nsec);
  return std::strtod(text, nullptr);
}

std::string withoutSlash(const std::string& name) {
  return !name.empty() && name.front() == '/' ? name.substr(1) : name;
}

LaserScan fromMessage(const sensor_msgs::LaserScan& message) {
  LaserScan scan;
  scan.stamp = toSeconds(message.header.stamp);
  scan.angle_min = static_cast<double>(message.angle_min);
  scan.angle_increment = static_cast<double>(message.angle_increment);
  scan.time_increment = static_cast<double>(message.time_increment);
  scan.range_min = static_cast<double>(message.range_min);
  scan.range_max = static_cast<double>(message.range_max);
  scan.ranges = message.ranges;
  scan.frame = withoutSlash(message.header.frame_id);
  return scan;
}

PointCloud toPointCloud(const sensor_msgs::PointCloud2& message) {
  PointBuffer buffer;
  for (const sensor_msgs::PointField& field : message.fields) {
    buffer.fields.push_back({field.name, field.offset, field.datatype});
  }
  buffer.width = message.width;
  buffer.height = message.height;
  buffer.point_step = message.point_step;
  buffer.row_step = message.row_step;
  buffer.big_endian = message.is_bigendian != 0;
  buffer.data = message.data.data();
  buffer.size = message.data.size();
  PointCloud cloud = unpackPoints(buffer, toSeconds(message.header.stamp));
  cloud.frame = withoutSlash(message.header.frame_id);
  return cloud;
}

ImuSample toImuSample(const sensor_msgs::Imu& message) {
  ImuSample sample;
  sample.stamp = toSeconds(message.header.stamp);
  const auto& q = message.orientation;
  const bool filled = q.x != 0.0 || q.y != 0.0 || q.z != 0.0 || q.w != 0.0;
  if (exists(message.orientation_covariance) && filled) {
    sample.world_R_imu = Eigen::Quaterniond(q.w, q.x, q.y, q.z);
  }
  if (exists(message.angular_velocity_covariance)) {
    sample.angular_velocity = toVector(message.angular_velocity);
  }
  if (exists(message.linear_acceleration_covariance)) {
    sample.linear_acceleration = toVector(message.linear_acceleration);
  }
  return sample;
}

HeightSample toHeightSample(const sensor_msgs::Range& message, double sensor_z) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double range = message.range;
  const bool limited = message.min_range < message.max_range;
  if (limited && message.range > message.max_range) range = kInfinity;
  if (limited && message.range < message.min_range) range = -kInfinity;
  return {toSeconds(message.header.stamp), range - sensor_z};
}

}  // namespace kestrel
