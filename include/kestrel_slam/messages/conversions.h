// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Transform.h>
#include <nav_msgs/OccupancyGrid.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Horizontal position and yaw. Not finite if the message is not finite.
Pose2 toPose2(const geometry_msgs::Pose& pose);

Eigen::Isometry3d fromMessage(const geometry_msgs::Transform& message);

/// Horizontal position and yaw of a pose. Throws std::invalid_argument with the reason if a number
/// is not finite or the quaternion is zero.
Pose2 planarFromMessage(const geometry_msgs::Pose& message);

geometry_msgs::Pose toMessage(const Pose2& pose);
geometry_msgs::Transform toTransformMessage(const Pose2& pose);
geometry_msgs::Transform toTransformMessage(const Eigen::Isometry3d& transform);

/// Variances of z, roll and pitch, which a 2D laser does not measure. They are so large that a
/// filter does not use the zeros in the message as measurements.
constexpr double kUnmeasuredHeightVariance = 1e4;            ///< m²
constexpr double kUnmeasuredTiltVariance = kPi * kPi / 3.0;  ///< rad²; of a uniform angle

/// Converts the pose and the covariance of (x, y, yaw), m² and rad², to the ROS order (x, y, z,
/// roll, pitch, yaw). The result is always symmetric, positive definite and finite, also for
/// invalid input.
geometry_msgs::PoseWithCovariance toMessage(const Pose2& pose, const Eigen::Matrix3d& covariance);

/// The caller must set the header.
nav_msgs::OccupancyGrid toMessage(MapSnapshot map);

/// A map of any node: values from 50 on are occupied. Empty if its size contradicts its data.
MapSnapshot fromMessage(const nav_msgs::OccupancyGrid& message);

/// A height as a range message. Its level frame marks it as a vertical height, not a distance along
/// a tilted axis.
sensor_msgs::Range toRangeMessage(const ros::Time& stamp, const std::string& level_frame,
                                  double height_m, double max_height_m);

/// The hits of a scan in the map frame. The caller must set the header.
sensor_msgs::PointCloud2 hitCloud(const PlanarScan& scan, const Pose2& map_T_base);

}  // namespace kestrel
