// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/message_instance.h>
#include <sensor_msgs/PointCloud2.h>

namespace kestrel {

/// Reads a PointCloud2 message of a bag. Throws std::exception if its bytes are damaged.
sensor_msgs::PointCloud2 deserializeCloud(const rosbag::MessageInstance& instance);

}  // namespace kestrel
