// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>

#include <string>

#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// A ROS time in seconds. The result is the double that is nearest to the decimal value, as if it
/// was read from a text file.
double toSeconds(const ros::Time& time);

/// Removes the leading slash of a frame or topic name. tf1 used it, tf2 does not accept it.
std::string withoutSlash(const std::string& name);

/// Copies all values without a check.
LaserScan fromMessage(const sensor_msgs::LaserScan& message);
/// Uses the strongest echo of each beam; without intensities the last one, which is the farthest.
/// A weak echo in front of a strong one is often rain, dust or the edge of an object. A beam
/// without an echo becomes NaN, because the message does not tell why there is none.
LaserScan fromMessage(const sensor_msgs::MultiEchoLaserScan& message);

/// The points of a message, with their times if the message has them (see unpackPoints()). The
/// stamp is the stamp of the header, s.
///
/// Throws std::invalid_argument with the reason: missing fields (with a list of the existing ones),
/// unsupported types, no points, or too few bytes.
PointCloud toPointCloud(const sensor_msgs::PointCloud2& message);
/// The same for the older message type, whose times are in a channel.
PointCloud toPointCloud(const sensor_msgs::PointCloud& message);

/// Copies the values of a message without a check. A value is absent if the driver marks it as
/// missing: by a covariance that begins with -1, or by an orientation of four zeros.
ImuSample toImuSample(const sensor_msgs::Imu& message);

/// A reading of a range finder at `sensor_z` (m, in the base frame). The result is the distance
/// from the base to the surface along the beam. It is +inf or -inf outside of the sensor's limits
/// (REP-117).
HeightSample toHeightSample(const sensor_msgs::Range& message, double sensor_z);

}  // namespace kestrel
