// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/recording.h"
#include "room_log.h"
#include "temporary_folder.h"

namespace kestrel {

/// Time of the first message, s.
constexpr double kBagStart = 1.7e9;

/// Beams `first` to `first + count` of a laser with 360 beams that turns ten times per second.
inline sensor_msgs::LaserScan turnPart(std::size_t first, std::size_t count,
                                       const std::string& frame = "laser") {
  constexpr double kBeams = 360.0, kBeamTime = 0.1 / kBeams;
  sensor_msgs::LaserScan scan;
  scan.header.stamp = ros::Time(kBagStart + static_cast<double>(first) * kBeamTime);
  scan.header.frame_id = frame;
  const double angle = static_cast<double>(first) * 2.0 * kPi / kBeams - kPi;
  scan.angle_min = static_cast<float>(std::remainder(angle, 2.0 * kPi));
  scan.angle_increment = static_cast<float>(2.0 * kPi / kBeams);
  scan.time_increment = static_cast<float>(kBeamTime);
  scan.range_min = 0.1F;
  scan.range_max = 12.0F;
  for (std::size_t i = 0; i < count; ++i) {
    const double direction = angle + static_cast<double>(i) * 2.0 * kPi / kBeams;
    scan.ranges.push_back(static_cast<float>(RoomFlight::range(0.5, direction)));
  }
  return scan;
}

inline tf2_msgs::TFMessage transform(const std::string& parent, const std::string& child,
                                     double time, double x, double yaw = 0.0) {
  geometry_msgs::TransformStamped t;
  t.header.stamp = ros::Time(time);
  t.header.frame_id = parent;
  t.child_frame_id = child;
  t.transform.translation.x = x;
  t.transform.rotation.z = std::sin(yaw / 2.0);
  t.transform.rotation.w = std::cos(yaw / 2.0);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(t);
  return message;
}

inline sensor_msgs::Imu imuReading(double time, const std::string& frame = "imu") {
  sensor_msgs::Imu imu;
  imu.header.stamp = ros::Time(time);
  imu.header.frame_id = frame;
  imu.orientation_covariance[0] = -1.0;
  imu.angular_velocity.z = 0.25;
  imu.linear_acceleration.z = 9.81;
  return imu;
}

/// Writes bags into a temporary folder and reads them.
class BagTest : public ::testing::Test {
 protected:
  using Fill = std::function<void(rosbag::Bag&)>;

  void writeBag(const Fill& fill, const std::string& path,
                rosbag::CompressionType compression = rosbag::compression::Uncompressed) {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    bag.setCompression(compression);
    fill(bag);
    bag.close();
  }
  std::unique_ptr<Recording> open(const Fill& fill,
                                  const RecordingOptions& options = RecordingOptions()) {
    writeBag(fill, path_);
    return openRecording(path_, options);
  }

  static std::vector<RecordedScan> readAll(Recording& recording) {
    std::vector<RecordedScan> scans;
    RecordedScan scan;
    while (recording.next(scan)) scans.push_back(scan);
    return scans;
  }

  /// All warnings, one per line.
  static std::string warningsOf(const Recording& recording) {
    std::string text;
    for (const std::string& warning : recording.warnings()) text += warning + "\n";
    return text;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("a.bag");
};

template <typename Message>
void record(rosbag::Bag& bag, const std::string& topic, double time, const Message& message) {
  bag.write(topic, ros::Time(time), message);
}

/// Full turns on a topic, ten per second.
inline void recordTurns(rosbag::Bag& bag, int count, const std::string& frame = "laser",
                        const std::string& topic = "/scan") {
  for (int i = 0; i < count; ++i) {
    const auto scan = turnPart(360 * static_cast<std::size_t>(i), 360, frame);
    record(bag, topic, kBagStart + 0.1 * i + 0.1, scan);
  }
}

}  // namespace kestrel
