// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/simulation/world.h"
#include "node_watcher.h"
#include "topic_nodes.h"

namespace kestrel {

/// One scan and the true pose of the base at its stamp.
struct SimulatedScan {
  LaserScan scan;
  Pose2 world_T_base;
};

/// A level flight through the laboratory with a small fast laser. Every call gives the same data.
struct TestFlight {
  World::Parts parts;
  std::vector<SimulatedScan> scans;

  /// Distance from a point in the plane to the nearest surface, m.
  double distanceToSurface(const Eigen::Vector2d& point) const;

  /// The true pose of the base in a map that starts at the first scan.
  Pose2 truth(std::size_t i) const {
    return scans.front().world_T_base.inverse() * scans[i].world_T_base;
  }
};

TestFlight laboratoryFlight(std::size_t scan_count);

/// The message of a simulated scan. `shift_s` moves its stamp.
sensor_msgs::LaserScan messageOf(const LaserScan& scan, const std::string& frame,
                                 double shift_s = 0.0);

geometry_msgs::TransformStamped transformOf(const std::string& parent, const std::string& child,
                                            const Pose2& parent_T_child, const ros::Time& stamp);

Pose2 poseOf(const geometry_msgs::Pose& message);
Pose2 poseOf(const geometry_msgs::Transform& message);

/// Simulates the rest of the robot: publishes scans and tf, and subscribes to all outputs of the
/// node. The items of its reports are "Scans", "Match" and "Map".
class MapperClient : public NodeWatcher {
 public:
  /// `ns`: the namespace of the mapper, "" for the root.
  explicit MapperClient(const std::string& ns = "");

  /// Waits until the mapper, and so many nodes in all, subscribe to the scans.
  bool connect(std::size_t nodes = 1);
  /// Whether the poses of the mapper arrive here.
  bool hearsPoses() const {
    return subscribers_[0].getNumPublishers() > 0 && subscribers_[1].getNumPublishers() > 0;
  }
  /// Whether the transforms of all nodes arrive here, and those of this node at all others.
  bool sharesTransforms() const { return connections_.areComplete(); }

  void publish(const sensor_msgs::LaserScan& scan) { scan_publisher_.publish(scan); }

  /// Publishes a scan and waits for its pose.
  std::optional<Pose2> match(const sensor_msgs::LaserScan& scan, double timeout_s = kPatience);

  ros::NodeHandle nh;
  tf2_ros::StaticTransformBroadcaster static_broadcaster;
  tf2_ros::TransformBroadcaster broadcaster;

  std::size_t poses_received = 0;
  geometry_msgs::PoseStamped pose;
  geometry_msgs::PoseWithCovarianceStamped pose_update;
  nav_msgs::OccupancyGrid map;
  nav_msgs::MapMetaData metadata;
  nav_msgs::Path trajectory;
  sensor_msgs::PointCloud2 cloud;

 private:
  TransformConnections connections_;
  ros::Publisher scan_publisher_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace kestrel
