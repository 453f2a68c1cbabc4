// SPDX-License-Identifier: BSD-3-Clause
#include "mapper_client.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 1000;

template <typename Message>
ros::Subscriber keepLast(ros::NodeHandle& nh, const std::string& topic, Message& place) {
  const boost::function<void(const Message&)> keep = [&place](const Message& message) {
    place = message;
  };
  return nh.subscribe<Message>(topic, kQueue, keep);
}

LaserModel testLaser() {
  LaserModel laser;
  laser.name = "test";
  laser.beams = 360;
  laser.angle_min = -kPi;
  laser.angle_increment = 2.0 * kPi / 360.0;
  laser.rate_hz = 10.0;
  laser.range_min = 0.05;
  laser.range_max = 12.0;
  laser.errors.sigma_m = 0.01;
  return laser;
}

double distanceToOutline(const Box& box, const Eigen::Vector2d& point) {
  const Eigen::Vector2d local =
      Eigen::Rotation2Dd(-box.yaw) * (point - Eigen::Vector2d(box.center.head<2>()));
  const Eigen::Vector2d beyond = local.cwiseAbs() - Eigen::Vector2d(box.size.head<2>()) / 2.0;
  const double inside = std::min(beyond.maxCoeff(), 0.0);
  return beyond.cwiseMax(0.0).norm() - inside;
}

}  // namespace

TestFlight laboratoryFlight(std::size_t scan_count) {
  Place laboratory = place("laboratory");
  laboratory.quadrotor.level = true;
  laboratory.quadrotor.gust_m_s2 = 0.0;
  VehicleModel vehicle;
  vehicle.laser = testLaser();
  SimulatedRecording recording(laboratory, vehicle, 1);
  TestFlight flight{laboratory.parts, {}};
  RecordedScan scan;
  while (flight.scans.size() < scan_count && recording.next(scan)) {
    flight.scans.push_back({scan.scan, recording.truth()[flight.scans.size()].pose});
  }
  return flight;
}

double TestFlight::distanceToSurface(const Eigen::Vector2d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Box& box : parts.boxes) nearest = std::min(nearest, distanceToOutline(box, point));
  for (const Cylinder& cylinder : parts.cylinders) {
    nearest = std::min(nearest, std::abs((point - cylinder.center).norm() - cylinder.radius));
  }
  return nearest;
}

sensor_msgs::LaserScan messageOf(const LaserScan& scan, const std::string& frame, double shift_s) {
  sensor_msgs::LaserScan message;
  message.header.frame_id = frame;
  message.header.stamp = ros::Time(scan.stamp + shift_s);
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges = scan.ranges;
  return message;
}

geometry_msgs::TransformStamped transformOf(const std::string& parent, const std::string& child,
                                            const Pose2& parent_T_child, const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.header.stamp = stamp;
  message.child_frame_id = child;
  message.transform = toTransformMessage(parent_T_child);
  return message;
}

Pose2 poseOf(const geometry_msgs::Pose& message) { return planarFromMessage(message); }

Pose2 poseOf(const geometry_msgs::Transform& message) {
  geometry_msgs::Pose pose;
  pose.position.x = message.translation.x;
  pose.position.y = message.translation.y;
  pose.orientation = message.rotation;
  return planarFromMessage(pose);
}

MapperClient::MapperClient(const std::string& ns)
    : NodeWatcher(ns.empty() ? "mapper" : ns + "/mapper", {"/tf", "/tf_static"}),
      nh(ns),
      connections_(nh) {
  scan_publisher_ = nh.advertise<sensor_msgs::LaserScan>("scan", kQueue);
  const boost::function<void(const geometry_msgs::PoseStamped&)> on_pose =
      [this](const geometry_msgs::PoseStamped& message) {
        pose = message;
        ++poses_received;
      };
  subscribers_ = {
      nh.subscribe<geometry_msgs::PoseStamped>("slam_out_pose", kQueue, on_pose),
      keepLast(nh, "poseupdate", pose_update),
      keepLast(nh, "map", map),
      keepLast(nh, "map_metadata", metadata),
      keepLast(nh, "trajectory", trajectory),
      keepLast(nh, "slam_cloud", cloud),
  };
}

bool MapperClient::connect(std::size_t nodes) {
  const bool connected =
      waitFor([&] { return scan_publisher_.getNumSubscribers() >= nodes && hearsPoses(); });
  return connected && waitFor([this] { return sharesTransforms(); });
}

std::optional<Pose2> MapperClient::match(const sensor_msgs::LaserScan& scan, double timeout_s) {
  publish(scan);
  const auto matched = [&] {
    return pose.header.stamp == scan.header.stamp && pose_update.header.stamp == scan.header.stamp;
  };
  if (!waitFor(matched, timeout_s)) return std::nullopt;
  return poseOf(pose.pose);
}

}  // namespace kestrel
