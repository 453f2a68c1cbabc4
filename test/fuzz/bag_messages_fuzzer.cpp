// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_scans.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/sensor/scan_projector.h"

// Messages with any contents. They are not made from bytes of the network, because roscpp itself
// then reserves as much memory as a broken length says.
namespace kestrel::fuzz {
namespace {

sensor_msgs::LaserScan anyLaserScanMessage(FuzzInput& input) {
  const LaserScan scan = anyLaserScan(input, 0.0);
  sensor_msgs::LaserScan message;
  message.header.stamp = ros::Time(input.raw<std::uint32_t>(), input.raw<std::uint16_t>());
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_max = input.anyFloat(-4.0, 4.0);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.scan_time = input.anyFloat(0.0, 0.1);
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges = scan.ranges;
  return message;
}

/// Numbers of a header are mostly small, so that they often fit the data.
std::uint32_t anySize(FuzzInput& input) {
  return input.below(16) == 1 ? input.raw<std::uint32_t>()
                              : static_cast<std::uint32_t>(input.below(64));
}

sensor_msgs::PointCloud2 anyCloudMessage(FuzzInput& input) {
  static const char* const kNames[] = {"x", "y", "z", "t", "time", "timestamp", "intensity", ""};
  sensor_msgs::PointCloud2 message;
  message.header.stamp = ros::Time(input.raw<std::uint32_t>(), 0);
  for (int fields = input.below(7); fields > 0; --fields) {
    sensor_msgs::PointField field;
    field.name = kNames[input.below(8)];
    field.offset = anySize(input);
    field.datatype = static_cast<std::uint8_t>(input.below(10));
    field.count = input.below(4) == 1 ? anySize(input) : 1;
    message.fields.push_back(field);
  }
  message.width = anySize(input);
  message.height = input.flag() ? 1 : anySize(input);
  message.point_step = anySize(input);
  message.row_step = input.flag() ? message.width * message.point_step : anySize(input);
  message.is_bigendian = input.flag();
  while (!input.atEnd()) message.data.push_back(input.byte());
  return message;
}

template <typename Message>
void fillNumbers(FuzzInput& input, std::vector<Message>& numbers) {
  for (int count = input.below(8); count > 0; --count) {
    numbers.push_back(static_cast<Message>(input.anyFloat(0.0, 9.0)));
  }
}

kestrel_slam::PlanarScan anyPlanarScanMessage(FuzzInput& input) {
  kestrel_slam::PlanarScan message;
  message.integrated_yaw = input.any(-9.0, 9.0);
  message.predicted_x = input.any(-9.0, 9.0);
  for (auto* numbers : {&message.origin_x, &message.origin_y, &message.end_x, &message.end_y}) {
    fillNumbers(input, *numbers);
  }
  for (int count = input.below(8); count > 0; --count) message.hit.push_back(input.byte());
  return message;
}

template <typename Sweep>
void project(const Sweep& sweep) {
  ScanProjector projector{ProjectorConfig()};
  const Projection projection = projector.project(sweep, Eigen::Isometry3d::Identity());
  if (projection.error == ScanError::kNone) checkScan(projection.scan);
}

void decode(FuzzInput& input) {
  switch (input.below(3)) {
    case 0:
      return project(fromMessage(anyLaserScanMessage(input)));
    case 1:
      return project(toPointCloud(anyCloudMessage(input)));
    default:
      fromPlanarScanMessage(anyPlanarScanMessage(input));
  }
}

}  // namespace

KESTREL_FUZZER(bag_messages, bytes) {
  FuzzInput input(bytes);
  expectResultOrReason([&] { decode(input); });
}

}  // namespace kestrel::fuzz
