// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_writer.h"

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stdexcept>

namespace kestrel {
namespace {

const std::string kScanFrame = "laser";
const std::string kVehicleFrame = "base_link";
const std::string kOdomFrame = "odom";
// Record tf 1 us before its scan, because players do not keep the order of messages with the same
// time.
const ros::Duration kAhead(0, 1000);

bool fitsRosTime(double seconds) {
  // In ROS, 0 means "no stamp", and rosbag rejects times before ros::TIME_MIN.
  constexpr double kMin = 1e-3;
  return seconds >= kMin &&
         seconds < static_cast<double>(std::numeric_limits<std::uint32_t>::max());
}

geometry_msgs::Quaternion yawQuaternion(double yaw) {
  geometry_msgs::Quaternion q;
  q.z = std::sin(yaw / 2.0);
  q.w = std::cos(yaw / 2.0);
  return q;
}

sensor_msgs::LaserScan toMessage(const LaserScan& scan, const ros::Time& stamp) {
  sensor_msgs::LaserScan message;
  message.header.stamp = stamp;
  message.header.frame_id = kScanFrame;
  const double steps = scan.ranges.empty() ? 0.0 : static_cast<double>(scan.ranges.size() - 1);
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_max = static_cast<float>(scan.angle_min + steps * scan.angle_increment);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges = scan.ranges;
  return message;
}

tf2_msgs::TFMessage toOdometryTransform(const Pose2& odom_T_base, const ros::Time& stamp) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = stamp;
  transform.header.frame_id = kOdomFrame;
  transform.child_frame_id = kVehicleFrame;
  transform.transform.translation.x = odom_T_base.x;
  transform.transform.translation.y = odom_T_base.y;
  transform.transform.rotation = yawQuaternion(odom_T_base.yaw);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  return message;
}

nav_msgs::Odometry toOdometry(const Pose2& odom_T_base, const ros::Time& stamp) {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = kOdomFrame;
  message.child_frame_id = kVehicleFrame;
  message.pose.pose.position.x = odom_T_base.x;
  message.pose.pose.position.y = odom_T_base.y;
  message.pose.pose.orientation = yawQuaternion(odom_T_base.yaw);
  return message;
}

/// A complete connection header, because rosbag does not add fields to a given header.
template <typename Message>
boost::shared_ptr<ros::M_string> latchedHeader(const std::string& topic) {
  const auto header = boost::make_shared<ros::M_string>();
  (*header)["topic"] = topic;
  (*header)["type"] = ros::message_traits::DataType<Message>::value();
  (*header)["md5sum"] = ros::message_traits::MD5Sum<Message>::value();
  (*header)["message_definition"] = ros::message_traits::Definition<Message>::value();
  (*header)["latching"] = "1";
  return header;
}

void writeMounting(rosbag::Bag& bag, const Eigen::Isometry3d& base_T_laser, const ros::Time& time) {
  const Eigen::Quaterniond q(base_T_laser.linear());
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = time;
  transform.header.frame_id = kVehicleFrame;
  transform.child_frame_id = kScanFrame;
  transform.transform.translation.x = base_T_laser.translation().x();
  transform.transform.translation.y = base_T_laser.translation().y();
  transform.transform.translation.z = base_T_laser.translation().z();
  transform.transform.rotation.x = q.x();
  transform.transform.rotation.y = q.y();
  transform.transform.rotation.z = q.z();
  transform.transform.rotation.w = q.w();
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  bag.write("/tf_static", time, message, latchedHeader<tf2_msgs::TFMessage>("/tf_static"));
}

void writeScan(rosbag::Bag& bag, const RecordedScan& scan, BagStamps stamps) {
  const ros::Time time(scan.time);
  const ros::Time stamp = stamps == BagStamps::kRecorded ? ros::Time(scan.scan.stamp) : time;
  if (scan.odom_T_base) {
    const ros::Time before = time - kAhead;
    bag.write("/odom", before, toOdometry(*scan.odom_T_base, stamp));
    bag.write("/tf", before, toOdometryTransform(*scan.odom_T_base, stamp));
  }
  bag.write("/scan", time, toMessage(scan.scan, stamp));
}

BagSummary writeMessages(rosbag::Bag& bag, Recording& recording, BagStamps stamps) {
  BagSummary summary;
  RecordedScan scan;
  while (recording.next(scan)) {
    if (!fitsRosTime(scan.time) || !fitsRosTime(scan.scan.stamp)) {
      ++summary.unwritable;
      continue;
    }
    if (summary.scans == 0) writeMounting(bag, scan.base_T_laser, ros::Time(scan.time) - kAhead);
    writeScan(bag, scan, stamps);
    ++summary.scans;
  }
  return summary;
}

}  // namespace

BagSummary writeBag(const std::string& path, Recording& recording, BagStamps stamps) {
  const std::string partial = path + ".part";
  std::error_code ignored;
  try {
    rosbag::Bag bag(partial, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::LZ4);
    const BagSummary summary = writeMessages(bag, recording, stamps);
    bag.close();
    std::filesystem::rename(partial, path);
    return summary;
  } catch (const std::exception& error) {
    std::filesystem::remove(partial, ignored);
    throw std::runtime_error(path + ": cannot be written (" + error.what() +
                             "); check that the folder exists and is writable");
  }
}

}  // namespace kestrel
