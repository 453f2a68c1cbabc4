// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_cloud.h"

#include <ros/serialization.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace kestrel {
namespace {

/// Skips through a serialized message and checks every length.
class ByteWalker {
 public:
  explicit ByteWalker(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  void skip(std::uint64_t count) {
    at_ += count;
    if (at_ > bytes_.size()) throw std::runtime_error("an array is longer than the message");
  }
  std::uint32_t length() {
    const std::uint64_t from = at_;
    std::uint32_t value = 0;
    skip(sizeof value);
    std::memcpy(&value, bytes_.data() + from, sizeof value);
    return value;
  }
  void skipArray() { skip(length()); }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::uint64_t at_ = 0;
};

/// Throws if an array of a serialized PointCloud2 is longer than the message. Without this check,
/// the ROS library would allocate up to 4 GB for a damaged length.
void requireArraysFit(const std::vector<std::uint8_t>& bytes) {
  constexpr std::uint64_t kNumber = sizeof(std::uint32_t);
  constexpr std::uint64_t kFieldTail = kNumber + 1 + kNumber;  // offset, datatype, count
  ByteWalker walker(bytes);
  walker.skip(3 * kNumber);  // sequence number and stamp
  walker.skipArray();        // frame
  walker.skip(2 * kNumber);  // height and width
  for (std::uint32_t left = walker.length(); left > 0; --left) {
    walker.skipArray();  // field name
    walker.skip(kFieldTail);
  }
  walker.skip(1 + 2 * kNumber);  // is_bigendian, point_step, row_step
  walker.skipArray();            // data
}

}  // namespace

sensor_msgs::PointCloud2 deserializeCloud(const rosbag::MessageInstance& instance) {
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(out);
  requireArraysFit(bytes);
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  sensor_msgs::PointCloud2 cloud;
  ros::serialization::deserialize(in, cloud);
  return cloud;
}

}  // namespace kestrel
