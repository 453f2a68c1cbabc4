#pragma once

#include <rosbag/message_instance.h>
#include <sensor_msgs/LaserScan.h>

#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel_slam {

/// Reads a LaserScan message of a bag. Throws std::exception where its bytes are damaged.
sensor_msgs::LaserScan deserializeScan(const rosbag::MessageInstance& instance);

/// Everything but the stamp, which a bag may lack.
LaserScan toLaserScan(const sensor_msgs::LaserScan& message);

}  // namespace kestrel_slam
