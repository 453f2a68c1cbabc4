// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_scan_messages.h"

#include <ros/serialization.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kNumber = sizeof(std::uint32_t);  // bytes

/// Skips through a serialized message and checks every length. Without this check, the ROS library
/// would allocate up to 16 GB for a damaged length.
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
  void skipArray(std::uint64_t element_size) { skip(length() * element_size); }
  void skipHeader() {
    skip(3 * kNumber);  // sequence number and stamp
    skipArray(1);       // frame
  }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::uint64_t at_ = 0;
};

constexpr std::uint64_t kScanNumbers = 7 * sizeof(float);  // angle_min to range_max

void walk(ByteWalker& bytes, const sensor_msgs::LaserScan& /*type*/) {
  bytes.skip(kScanNumbers);
  bytes.skipArray(sizeof(float));  // ranges
  bytes.skipArray(sizeof(float));  // intensities
}

void walk(ByteWalker& bytes, const sensor_msgs::MultiEchoLaserScan& /*type*/) {
  bytes.skip(kScanNumbers);
  for (int array = 0; array < 2; ++array) {  // ranges, intensities
    for (std::uint32_t left = bytes.length(); left > 0; --left) bytes.skipArray(sizeof(float));
  }
}

void walk(ByteWalker& bytes, const sensor_msgs::PointCloud& /*type*/) {
  bytes.skipArray(3 * sizeof(float));  // points
  for (std::uint32_t left = bytes.length(); left > 0; --left) {
    bytes.skipArray(1);  // name of the channel
    bytes.skipArray(sizeof(float));
  }
}

void walk(ByteWalker& bytes, const sensor_msgs::PointCloud2& /*type*/) {
  bytes.skip(2 * kNumber);  // height and width
  for (std::uint32_t left = bytes.length(); left > 0; --left) {
    bytes.skipArray(1);                 // name of the field
    bytes.skip(kNumber + 1 + kNumber);  // offset, datatype, count
  }
  bytes.skip(1 + 2 * kNumber);  // is_bigendian, point_step, row_step
  bytes.skipArray(1);           // data
}

template <typename Message>
Message deserialize(const rosbag::MessageInstance& instance) {
  if (instance.getMD5Sum() != ros::message_traits::MD5Sum<Message>::value()) {
    throw std::runtime_error("it has another version of " + instance.getDataType());
  }
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(out);
  Message message;
  ByteWalker walker(bytes);
  walker.skipHeader();
  walk(walker, message);
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(in, message);
  return message;
}

LaserScan contentOf(const sensor_msgs::LaserScan& message) { return fromMessage(message); }
LaserScan contentOf(const sensor_msgs::MultiEchoLaserScan& message) { return fromMessage(message); }
PointCloud contentOf(const sensor_msgs::PointCloud2& message) { return toPointCloud(message); }
PointCloud contentOf(const sensor_msgs::PointCloud& message) { return toPointCloud(message); }

void store(LaserScan content, BagScan& result) { result.scan = std::move(content); }
void store(PointCloud content, BagScan& result) { result.cloud = std::move(content); }

template <typename Message>
BagScan readAs(const rosbag::MessageInstance& instance) {
  const Message message = deserialize<Message>(instance);
  BagScan result;
  store(contentOf(message), result);
  result.stamped = !message.header.stamp.isZero();
  result.time = result.stamped ? message.header.stamp : instance.getTime();
  result.recorded = toSeconds(instance.getTime());
  result.frame = withoutSlash(message.header.frame_id);
  result.scan.stamp = toSeconds(result.time);
  if (result.cloud) result.cloud->stamp = result.scan.stamp;
  return result;
}

/// How to read one type of message.
struct ScanReader {
  std::string type, md5;
  BagScan (*read)(const rosbag::MessageInstance&);
};

template <typename Message>
ScanReader readerOf() {
  return {ros::message_traits::DataType<Message>::value(),
          ros::message_traits::MD5Sum<Message>::value(), &readAs<Message>};
}

const ScanReader& readerOf(const std::string& type) {
  static const std::vector<ScanReader> kReaders = {
      readerOf<sensor_msgs::LaserScan>(), readerOf<sensor_msgs::MultiEchoLaserScan>(),
      readerOf<sensor_msgs::PointCloud2>(), readerOf<sensor_msgs::PointCloud>()};
  for (const ScanReader& reader : kReaders) {
    if (reader.type == type) return reader;
  }
  throw std::runtime_error(type + " is not a type of scans");
}

}  // namespace

const std::vector<std::string>& scanTypes() {
  static const std::vector<std::string> kTypes = {"sensor_msgs/LaserScan",
                                                  "sensor_msgs/MultiEchoLaserScan"};
  return kTypes;
}

const std::vector<std::string>& cloudTypes() {
  static const std::vector<std::string> kTypes = {"sensor_msgs/PointCloud2",
                                                  "sensor_msgs/PointCloud"};
  return kTypes;
}

std::string md5OfScanType(const std::string& type) { return readerOf(type).md5; }

BagScan readBagScan(const rosbag::MessageInstance& instance) {
  return readerOf(instance.getDataType()).read(instance);
}

}  // namespace kestrel
