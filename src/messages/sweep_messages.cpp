// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/sweep_messages.h"

#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>

namespace kestrel {

sensor_msgs::LaserScan toScanMessage(const LaserScan& scan) {
  sensor_msgs::LaserScan message;
  message.header.stamp = ros::Time(scan.stamp);
  const double beams = static_cast<double>(std::max<std::size_t>(scan.ranges.size(), 1));
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_max = static_cast<float>(scan.angle_min + (beams - 1.0) * scan.angle_increment);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.scan_time = static_cast<float>(beams * scan.time_increment);
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges = scan.ranges;
  return message;
}

sensor_msgs::PointCloud2 toCloudMessage(const PointCloud& cloud) {
  using Field = sensor_msgs::PointField;
  sensor_msgs::PointCloud2 message;
  message.header.stamp = ros::Time(cloud.stamp);
  sensor_msgs::PointCloud2Modifier modifier(message);
  modifier.setPointCloud2Fields(4, "x", 1, Field::FLOAT32, "y", 1, Field::FLOAT32, "z", 1,
                                Field::FLOAT32, "time", 1, Field::FLOAT32);
  modifier.resize(cloud.points.size());
  message.is_dense = false;
  sensor_msgs::PointCloud2Iterator<float> x(message, "x"), time(message, "time");
  for (const PointCloud::Point& point : cloud.points) {
    x[0] = point.x;
    x[1] = point.y;
    x[2] = point.z;
    *time = point.time;
    ++x;
    ++time;
  }
  return message;
}

}  // namespace kestrel
