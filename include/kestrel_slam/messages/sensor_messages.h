// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>

#include <string>

#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// A ROS time in seconds, rounded once: the double that the same decimals give when they are read.
double toSeconds(const ros::Time& time);

/// A frame or topic name without its leading slash (tf1 wrote it, tf2 refuses it).
std::string withoutSlash(const std::string& name);

/// The message as it is.
LaserScan fromMessage(const sensor_msgs::LaserScan& message);

/// The points of a message, with their times where it has them (see unpackPoints()). The stamp is
/// that of the header, s.
///
/// Throws std::invalid_argument that names what is wrong: fields that are missing (and those there
/// are), types that are unsupported, no points, fewer bytes than promised.
PointCloud toPointCloud(const sensor_msgs::PointCloud2& message);

/// The values of a message as they are, whatever they are. What the driver says that it does not
/// have (a covariance that begins with -1; an orientation of four zeros) is absent.
ImuSample toImuSample(const sensor_msgs::Imu& message);

/// A reading of a range finder at `sensor_z` (m, in the base's frame): what the base is over what
/// was hit, along the beam. Outside of the sensor's limits it is +inf or -inf (REP-117).
HeightSample toHeightSample(const sensor_msgs::Range& message, double sensor_z);

}  // namespace kestrel
