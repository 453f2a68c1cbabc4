// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>

#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_scans.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/sensor/scan_projector.h"

// Messages as they come from the network: any bytes that can be deserialized.
namespace kestrel::fuzz {
namespace {

template <typename Message>
Message messageOf(const std::string& bytes) {
  std::vector<std::uint8_t> copy(bytes.begin() + 1, bytes.end());
  ros::serialization::IStream stream(copy.data(), static_cast<std::uint32_t>(copy.size()));
  Message message;
  ros::serialization::deserialize(stream, message);
  return message;
}

template <typename Sweep>
void project(const Sweep& sweep) {
  ScanProjector projector{ProjectorConfig()};
  const Projection projection = projector.project(sweep, Eigen::Isometry3d::Identity());
  if (projection.error == ScanError::kNone) checkScan(projection.scan);
}

void decode(int kind, const std::string& bytes) {
  if (kind == 0) project(fromMessage(messageOf<sensor_msgs::LaserScan>(bytes)));
  if (kind == 1) project(toPointCloud(messageOf<sensor_msgs::PointCloud2>(bytes)));
  if (kind == 2) toImuSample(messageOf<sensor_msgs::Imu>(bytes));
  if (kind == 3) toHeightSample(messageOf<sensor_msgs::Range>(bytes), 0.1);
  if (kind == 4) fromPlanarScanMessage(messageOf<kestrel_slam::PlanarScan>(bytes));
}

}  // namespace

KESTREL_FUZZER(bag_messages, bytes) {
  constexpr int kKinds = 5;
  if (bytes.empty()) return;
  expectResultOrReason([&] { decode(static_cast<std::uint8_t>(bytes[0]) % kKinds, bytes); });
}

}  // namespace kestrel::fuzz
