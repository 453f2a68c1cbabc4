// SPDX-License-Identifier: BSD-3-Clause
#include "tilting_flight.h"

#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"

namespace kestrel {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kHalfLength = 4.0;  // m, of the room along x
constexpr double kHalfWidth = 3.0;   // m, along y
constexpr double kFieldOfView = 1.5 * kPi;
constexpr double kStep = kFieldOfView / (TiltingFlight::kBeams - 1);

/// Distance to the wall along a direction.
double toWalls(const Vector3d& from, const Vector3d& direction) {
  const double far = std::numeric_limits<double>::infinity();
  const auto along = [&](double position, double step, double half) {
    return step == 0.0 ? far : (std::copysign(half, step) - position) / step;
  };
  return std::min(along(from.x(), direction.x(), kHalfLength),
                  along(from.y(), direction.y(), kHalfWidth));
}

}  // namespace

Eigen::Quaterniond TiltingFlight::world_R_base(double time) const {
  const double phase = 2.0 * kPi * std::fmod(time, 1.0);
  return AngleAxisd(yaw_rate * std::fmod(time, 1000.0), Vector3d::UnitZ()) *
         AngleAxisd(pitch_amplitude * std::cos(phase), Vector3d::UnitY()) *
         AngleAxisd(roll_amplitude * std::sin(phase), Vector3d::UnitX());
}

Vector3d TiltingFlight::bodyRate(double time) const {
  constexpr double kHalfStep = 1e-4;  // s
  const AngleAxisd turn(world_R_base(time - kHalfStep).inverse() * world_R_base(time + kHalfStep));
  return turn.angle() / (2.0 * kHalfStep) * turn.axis();
}

sensor_msgs::Imu TiltingFlight::imu(double time, const std::string& frame,
                                    const Eigen::Quaterniond& base_R_imu) const {
  const Eigen::Quaterniond world_R_imu = world_R_base(time) * base_R_imu;
  const Vector3d rate = base_R_imu.inverse() * bodyRate(time);
  const Vector3d force = world_R_imu.inverse() * Vector3d(0.0, 0.0, kGravity);
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(time);
  message.header.frame_id = frame;
  message.orientation.w = world_R_imu.w();
  message.orientation.x = world_R_imu.x();
  message.orientation.y = world_R_imu.y();
  message.orientation.z = world_R_imu.z();
  message.angular_velocity.x = rate.x();
  message.angular_velocity.y = rate.y();
  message.angular_velocity.z = rate.z();
  message.linear_acceleration.x = force.x();
  message.linear_acceleration.y = force.y();
  message.linear_acceleration.z = force.z();
  return message;
}

TiltingFlight::Beam TiltingFlight::beam(int i, double time,
                                        const Eigen::Isometry3d& base_T_laser) const {
  const Eigen::Quaterniond rotation = world_R_base(time + i * kTimeIncrement);
  const double angle = -0.5 * kFieldOfView + i * kStep;
  const Vector3d from = rotation * base_T_laser.translation();
  const Vector3d direction =
      rotation * base_T_laser.linear() * Vector3d(std::cos(angle), std::sin(angle), 0.0);
  const double range = toWalls(from, direction);
  return {range, from + range * direction};
}

sensor_msgs::LaserScan TiltingFlight::scan(double time, const std::string& frame,
                                           const Eigen::Isometry3d& base_T_laser) const {
  sensor_msgs::LaserScan message;
  message.header.stamp = ros::Time(time);
  message.header.frame_id = frame;
  message.angle_min = static_cast<float>(-0.5 * kFieldOfView);
  message.angle_increment = static_cast<float>(kStep);
  message.angle_max = static_cast<float>(0.5 * kFieldOfView);
  message.time_increment = static_cast<float>(kTimeIncrement);
  message.range_min = 0.1F;
  message.range_max = 30.0F;
  for (int i = 0; i < kBeams; ++i) {
    message.ranges.push_back(static_cast<float>(beam(i, time, base_T_laser).range));
  }
  return message;
}

std::vector<Eigen::Vector2f> TiltingFlight::hits(double time, const Eigen::Isometry3d& base_T_laser,
                                                 double slice_m) const {
  const Eigen::Quaterniond now = world_R_base(time);
  const Vector3d nose = now * Vector3d::UnitX();
  const AngleAxisd undo_yaw(-std::atan2(nose.y(), nose.x()), Vector3d::UnitZ());
  const double laser_height = (now * base_T_laser.translation()).z();
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < kBeams; ++i) {
    const Vector3d end = beam(i, time, base_T_laser).end;
    if (std::abs(end.z() - laser_height) > slice_m) continue;
    points.push_back((undo_yaw * end).head<2>().cast<float>());
  }
  return points;
}

Eigen::Isometry3d mounting(double x, double y, double z, double roll, double pitch, double yaw) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
                        AngleAxisd(roll, Vector3d::UnitX()))
                           .toRotationMatrix();
  transform.translation() << x, y, z;
  return transform;
}

geometry_msgs::TransformStamped transformMessage(const std::string& parent,
                                                 const std::string& child,
                                                 const Eigen::Isometry3d& parent_T_child,
                                                 double time) {
  const Eigen::Quaterniond rotation(parent_T_child.linear());
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.header.stamp = ros::Time(time);
  message.child_frame_id = child;
  message.transform.translation.x = parent_T_child.translation().x();
  message.transform.translation.y = parent_T_child.translation().y();
  message.transform.translation.z = parent_T_child.translation().z();
  message.transform.rotation.w = rotation.w();
  message.transform.rotation.x = rotation.x();
  message.transform.rotation.y = rotation.y();
  message.transform.rotation.z = rotation.z();
  return message;
}

}  // namespace kestrel
