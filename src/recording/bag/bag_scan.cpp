// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_scan.h"

#include <ros/serialization.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace kestrel {
namespace {

/// True if the arrays of a serialized LaserScan are not longer than the message. Without this
/// check, the ROS library would allocate up to 16 GB for a damaged length.
bool arraysFit(const std::vector<std::uint8_t>& bytes) {
  constexpr std::uint64_t kLength = sizeof(std::uint32_t);
  constexpr std::uint64_t kHeader = 3 * sizeof(std::uint32_t);  // sequence number and stamp
  constexpr std::uint64_t kScalars = 7 * sizeof(float);         // angle_min to range_max
  std::uint64_t at = kHeader;
  const auto skipArray = [&](std::uint64_t element_size) {
    std::uint32_t count = 0;
    if (at + kLength > bytes.size()) return false;
    std::memcpy(&count, bytes.data() + at, kLength);
    at += kLength + count * element_size;
    return at <= bytes.size();
  };
  if (!skipArray(1)) return false;  // frame
  at += kScalars;
  return skipArray(sizeof(float)) && skipArray(sizeof(float));  // ranges, intensities
}

}  // namespace

sensor_msgs::LaserScan deserializeScan(const rosbag::MessageInstance& instance) {
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(out);
  if (!arraysFit(bytes)) throw std::runtime_error("an array is longer than the message");
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  sensor_msgs::LaserScan scan;
  ros::serialization::deserialize(in, scan);
  return scan;
}

}  // namespace kestrel
