// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/message_instance.h>
#include <sensor_msgs/LaserScan.h>

namespace kestrel {

/// Reads a LaserScan message of a bag. Throws std::exception if its bytes are damaged.
sensor_msgs::LaserScan deserializeScan(const rosbag::MessageInstance& instance);

}  // namespace kestrel
