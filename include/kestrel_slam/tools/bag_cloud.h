#pragma once

#include <rosbag/message_instance.h>
#include <sensor_msgs/PointCloud2.h>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel_slam {

/// Reads a PointCloud2 message of a bag. Throws std::exception where its bytes are damaged.
sensor_msgs::PointCloud2 deserializeCloud(const rosbag::MessageInstance& instance);

/// The points of a message, with their times where it has them (see unpackPoints()). The stamp is
/// that of the header, s.
///
/// Throws std::invalid_argument that names what is wrong: fields that are missing (and those there
/// are), types that are unsupported, no points, fewer bytes than promised.
PointCloud toPointCloud(const sensor_msgs::PointCloud2& message);

}  // namespace kestrel_slam
