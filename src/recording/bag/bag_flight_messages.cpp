// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_flight_messages.h"

#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/square.h"

namespace kestrel {
namespace {

constexpr const char* kWorldFrame = "world";
constexpr const char* kBaseFrame = "base_link";
constexpr const char* kLaserFrame = "laser";
constexpr const char* kLidarFrame = "velodyne";
constexpr const char* kImuFrame = "imu_link";
constexpr const char* kRangeFinderFrame = "range_finder";

template <typename Message>
Message stamped(const ros::Time& stamp, const char* frame) {
  Message message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  return message;
}

template <typename Xyz>
void assign(Xyz& to, const Eigen::Vector3d& from) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

void assign(geometry_msgs::Quaternion& to, const Eigen::Quaterniond& from) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
  to.w = from.w();
}

/// Sets a row-major 3 x 3 matrix with the same variance on the diagonal.
void setVariance(boost::array<double, 9>& covariance, double variance) {
  constexpr std::size_t kDiagonalStep = 4;
  for (std::size_t i = 0; i < covariance.size(); i += kDiagonalStep) covariance[i] = variance;
}

/// The ring of the lidar that measured a point; the lowest ring is 0.
std::uint16_t ringOf(const PointCloud::Point& point, const std::vector<double>& elevations) {
  const double elevation = std::atan2(point.z, std::hypot(point.x, point.y));
  const auto nearest = std::min_element(
      elevations.begin(), elevations.end(),
      [&](double a, double b) { return std::abs(a - elevation) < std::abs(b - elevation); });
  return static_cast<std::uint16_t>(
      std::count_if(elevations.begin(), elevations.end(), [&](double e) { return e < *nearest; }));
}

geometry_msgs::TransformStamped mounting(const char* frame, const Eigen::Isometry3d& base_T_sensor,
                                         const ros::Time& stamp) {
  auto transform = stamped<geometry_msgs::TransformStamped>(stamp, kBaseFrame);
  transform.child_frame_id = frame;
  assign(transform.transform.translation, base_T_sensor.translation());
  assign(transform.transform.rotation, Eigen::Quaterniond(base_T_sensor.linear()));
  return transform;
}

}  // namespace

sensor_msgs::LaserScan toMessage(const LaserScan& scan, const ros::Time& stamp,
                                 const VehicleModel& vehicle) {
  auto message = stamped<sensor_msgs::LaserScan>(stamp, kLaserFrame);
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.angle_max = static_cast<float>(
      scan.angle_min + (static_cast<double>(scan.ranges.size()) - 1.0) * scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.scan_time = static_cast<float>(1.0 / vehicle.laser->rate_hz);
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges = scan.ranges;
  return message;
}

sensor_msgs::PointCloud2 toMessage(const PointCloud& cloud, const ros::Time& stamp,
                                   const VehicleModel& vehicle) {
  auto message = stamped<sensor_msgs::PointCloud2>(stamp, kLidarFrame);
  std::vector<PointCloud::Point>
      points;  // without missing returns, as the velodyne_driver sends them
  std::copy_if(cloud.points.begin(), cloud.points.end(), std::back_inserter(points),
               [](const PointCloud::Point& p) { return std::isfinite(p.x); });
  sensor_msgs::PointCloud2Modifier modifier(message);
  using Field = sensor_msgs::PointField;
  modifier.setPointCloud2Fields(6, "x", 1, Field::FLOAT32, "y", 1, Field::FLOAT32, "z", 1,
                                Field::FLOAT32, "intensity", 1, Field::FLOAT32, "ring", 1,
                                Field::UINT16, "time", 1, Field::FLOAT32);
  modifier.resize(points.size());
  message.is_dense = true;
  sensor_msgs::PointCloud2Iterator<float> x(message, "x"), intensity(message, "intensity"),
      time(message, "time");
  sensor_msgs::PointCloud2Iterator<std::uint16_t> ring(message, "ring");
  for (const PointCloud::Point& point : points) {
    x[0] = point.x;
    x[1] = point.y;
    x[2] = point.z;
    *intensity = 0.0F;  // reflectivity is not simulated
    *ring = ringOf(point, vehicle.lidar->elevations);
    *time = point.time;
    ++x, ++intensity, ++ring, ++time;
  }
  return message;
}

sensor_msgs::Imu toMessage(const ImuSample& sample, const ros::Time& stamp,
                           const VehicleModel& vehicle) {
  constexpr double kNotGiven = -1.0;
  auto message = stamped<sensor_msgs::Imu>(stamp, kImuFrame);
  const ImuModel& imu = *vehicle.imu;
  if (sample.world_R_imu) {
    assign(message.orientation, *sample.world_R_imu);
    setVariance(message.orientation_covariance, square(imu.attitude_sigma_rad));
    message.orientation_covariance.back() = square(imu.yaw_sigma_rad);
  } else {
    message.orientation.w = 1.0;
    message.orientation_covariance[0] = kNotGiven;
  }
  if (sample.angular_velocity) {
    assign(message.angular_velocity, *sample.angular_velocity);
    setVariance(message.angular_velocity_covariance, square(imu.gyro_noise) * imu.rate_hz);
  } else {
    message.angular_velocity_covariance[0] = kNotGiven;
  }
  if (sample.linear_acceleration) {
    assign(message.linear_acceleration, *sample.linear_acceleration);
    setVariance(message.linear_acceleration_covariance,
                square(imu.accelerometer_noise) * imu.rate_hz);
  } else {
    message.linear_acceleration_covariance[0] = kNotGiven;
  }
  return message;
}

sensor_msgs::Range toMessage(const HeightSample& sample, const ros::Time& stamp,
                             const VehicleModel& vehicle) {
  constexpr float kFieldOfView = 0.03F;  // rad, of a small infrared range finder
  auto message = stamped<sensor_msgs::Range>(stamp, kRangeFinderFrame);
  message.radiation_type = sensor_msgs::Range::INFRARED;
  message.field_of_view = kFieldOfView;
  message.min_range = static_cast<float>(vehicle.range_finder->range_min);
  message.max_range = static_cast<float>(vehicle.range_finder->range_max);
  message.range = static_cast<float>(sample.height_m);
  return message;
}

geometry_msgs::PointStamped toMessage(const Barometer& barometer, const ros::Time& stamp,
                                      const VehicleModel&) {
  auto message = stamped<geometry_msgs::PointStamped>(stamp, kWorldFrame);
  message.point.z = barometer.sample.height_m;
  return message;
}

nav_msgs::Odometry toMessage(const TruePose& pose, const ros::Time& stamp, const VehicleModel&) {
  auto message = stamped<nav_msgs::Odometry>(stamp, kWorldFrame);
  message.child_frame_id = kBaseFrame;
  const TrueState& state = pose.state;
  const Eigen::Matrix3d world_R_base = state.world_T_base.linear();
  assign(message.pose.pose.position, state.world_T_base.translation());
  assign(message.pose.pose.orientation, Eigen::Quaterniond(world_R_base));
  assign(message.twist.twist.linear, world_R_base.transpose() * state.velocity);
  assign(message.twist.twist.angular, state.angular_velocity);
  return message;
}

geometry_msgs::PoseArray toMessage(const TrueWalkers& walkers, const ros::Time& stamp,
                                   const VehicleModel&) {
  auto message = stamped<geometry_msgs::PoseArray>(stamp, kWorldFrame);
  for (const Eigen::Vector2d& position : walkers.positions) {
    geometry_msgs::Pose pose;
    pose.position.x = position.x();
    pose.position.y = position.y();
    pose.orientation.w = 1.0;
    message.poses.push_back(pose);
  }
  return message;
}

tf2_msgs::TFMessage mountings(const VehicleModel& vehicle, const ros::Time& stamp) {
  tf2_msgs::TFMessage message;
  const auto add = [&](const char* frame, const Eigen::Isometry3d& base_T_sensor) {
    message.transforms.push_back(mounting(frame, base_T_sensor, stamp));
  };
  if (vehicle.laser) add(kLaserFrame, vehicle.base_T_laser);
  if (vehicle.lidar) add(kLidarFrame, vehicle.base_T_lidar);
  if (vehicle.imu) add(kImuFrame, Eigen::Isometry3d(vehicle.base_R_imu));
  if (vehicle.range_finder) {
    // A sensor_msgs/Range is measured along the x axis, which must point down here.
    const Eigen::AngleAxisd nose_down(kPi / 2.0, Eigen::Vector3d::UnitY());
    add(kRangeFinderFrame, Eigen::Isometry3d(nose_down));
  }
  return message;
}

}  // namespace kestrel
