// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <rosbag/message_instance.h>

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// A recorded scan or cloud with its frame and time for tf lookups.
struct BagScan {
  LaserScan scan;  ///< of a cloud: only the stamp
  std::optional<PointCloud> cloud;
  std::string frame;
  ros::Time time;  ///< the stamp, or the time of recording if there is no stamp
  bool stamped = true;
  double recorded = 0.0;  ///< time of recording, s
};

/// The message types with scans of a 2D laser: LaserScan and MultiEchoLaserScan.
const std::vector<std::string>& scanTypes();
/// The message types with clouds of a 3D lidar: PointCloud2 and PointCloud.
const std::vector<std::string>& cloudTypes();
/// The md5 sum of a type of these lists.
std::string md5OfScanType(const std::string& type);

/// Reads a message of one of these types. Throws std::invalid_argument if a cloud cannot be used
/// (for example without coordinates), and another std::exception if the bytes are damaged.
BagScan readBagScan(const rosbag::MessageInstance& instance);

}  // namespace kestrel
