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

/// Position and yaw seen from above; not finite where the message is not.
Pose2 toPose2(const geometry_msgs::Pose& pose);

Eigen::Isometry3d fromMessage(const geometry_msgs::Transform& message);

/// Position and yaw of a pose, seen from above. Throws std::invalid_argument that says what is
/// wrong where a number is not finite or the quaternion has no length.
Pose2 planarFromMessage(const geometry_msgs::Pose& message);

geometry_msgs::Pose toMessage(const Pose2& pose);
geometry_msgs::Transform toTransformMessage(const Pose2& pose);

/// What z, roll and pitch get, which a 2D laser does not measure: variances so large that no filter
/// takes the zeros there for a measurement.
constexpr double kUnmeasuredHeightVariance = 1e4;            ///< m²
constexpr double kUnmeasuredTiltVariance = kPi * kPi / 3.0;  ///< rad²; of any angle at all

/// The pose with the covariance of (x, y, yaw), m² and rad², in the order of ROS (x, y, z, roll,
/// pitch, yaw): symmetric, positive definite and finite, whatever comes in.
geometry_msgs::PoseWithCovariance toMessage(const Pose2& pose, const Eigen::Matrix3d& covariance);

/// The header is left to the caller.
nav_msgs::OccupancyGrid toMessage(MapSnapshot map);

/// A height in a level frame, which says that it is the height itself, not a slanted distance.
sensor_msgs::Range toRangeMessage(const ros::Time& stamp, const std::string& level_frame,
                                  double height_m, double max_height_m);

/// The hits of a scan in the map frame; the header is left to the caller.
sensor_msgs::PointCloud2 hitCloud(const PlanarScan& scan, const Pose2& map_T_base);

}  // namespace kestrel
