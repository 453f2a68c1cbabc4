#include "kestrel_slam/tools/bag_flight_writer.h"

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace kestrel_slam {
namespace {

constexpr const char* kWorldFrame = "world";
constexpr const char* kBaseFrame = "base_link";
constexpr const char* kLaserFrame = "laser";

geometry_msgs::Quaternion yawQuaternion(double yaw) {
  geometry_msgs::Quaternion q;
  q.z = std::sin(yaw / 2.0);
  q.w = std::cos(yaw / 2.0);
  return q;
}

tf2_msgs::TFMessage mountingMessage(const Pose2& base_T_laser, const ros::Time& stamp) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = stamp;
  transform.header.frame_id = kBaseFrame;
  transform.child_frame_id = kLaserFrame;
  transform.transform.translation.x = base_T_laser.x;
  transform.transform.translation.y = base_T_laser.y;
  transform.transform.rotation = yawQuaternion(base_T_laser.theta);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  return message;
}

/// Makes rosbag play latch the static transforms. rosbag adds nothing to a header that is given.
boost::shared_ptr<ros::M_string> latchedHeader() {
  namespace traits = ros::message_traits;
  auto header = boost::make_shared<ros::M_string>();
  (*header)["type"] = traits::datatype<tf2_msgs::TFMessage>();
  (*header)["md5sum"] = traits::md5sum<tf2_msgs::TFMessage>();
  (*header)["message_definition"] = traits::definition<tf2_msgs::TFMessage>();
  (*header)["callerid"] = "/simulate_flight";
  (*header)["latching"] = "1";
  return header;
}

sensor_msgs::LaserScan scanMessage(const LaserScan& scan, const ros::Time& stamp) {
  sensor_msgs::LaserScan message;
  message.header.stamp = stamp;
  message.header.frame_id = kLaserFrame;
  message.angle_min = static_cast<float>(scan.angle_min);
  message.angle_increment = static_cast<float>(scan.angle_increment);
  message.angle_max = static_cast<float>(
      scan.angle_min + static_cast<double>(scan.ranges.size() - 1) * scan.angle_increment);
  message.time_increment = static_cast<float>(scan.time_increment);
  message.range_min = static_cast<float>(scan.range_min);
  message.range_max = static_cast<float>(scan.range_max);
  message.ranges = scan.ranges;
  return message;
}

/// The pose of scan `i`, and its velocity from the scans around it.
nav_msgs::Odometry truthMessage(const std::vector<SimulatedScan>& flight, std::size_t i,
                                const ros::Time& stamp) {
  const Pose2& pose = flight[i].world_T_base;
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = kWorldFrame;
  message.child_frame_id = kBaseFrame;
  message.pose.pose.position.x = pose.x;
  message.pose.pose.position.y = pose.y;
  message.pose.pose.orientation = yawQuaternion(pose.theta);
  const SimulatedScan& before = flight[i == 0 ? 0 : i - 1];
  const SimulatedScan& after = flight[std::min(i + 1, flight.size() - 1)];
  const double seconds = after.scan.stamp - before.scan.stamp;
  if (seconds > 0.0) {
    const Pose2 from = pose.inverse() * before.world_T_base;
    const Pose2 to = pose.inverse() * after.world_T_base;
    message.twist.twist.linear.x = (to.x - from.x) / seconds;
    message.twist.twist.linear.y = (to.y - from.y) / seconds;
    message.twist.twist.angular.z = normalizeAngle(to.theta - from.theta) / seconds;
  }
  return message;
}

void writeMessages(rosbag::Bag& bag, const std::vector<SimulatedScan>& flight,
                   const Pose2& base_T_laser) {
  for (std::size_t i = 0; i < flight.size(); ++i) {
    const ros::Time stamp(flight[i].scan.stamp);
    if (i == 0) {
      bag.write("/tf_static", stamp, mountingMessage(base_T_laser, stamp), latchedHeader());
    }
    bag.write("/ground_truth", stamp, truthMessage(flight, i, stamp));
    bag.write("/scan", stamp, scanMessage(flight[i].scan, stamp));
  }
}

}  // namespace

void writeFlightBag(const std::string& path, const std::vector<SimulatedScan>& flight,
                    const Pose2& base_T_laser) {
  const std::string unfinished = path + ".part";
  try {
    rosbag::Bag bag(unfinished, rosbag::bagmode::Write);
    writeMessages(bag, flight, base_T_laser);
    bag.close();
  } catch (const rosbag::BagException& error) {
    std::remove(unfinished.c_str());
    throw std::runtime_error(path + ": cannot write the bag (" + error.what() +
                             "); check the folder");
  }
  if (std::rename(unfinished.c_str(), path.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(unfinished.c_str());
    throw std::runtime_error(path + ": cannot write the bag (" + reason + "); choose another name");
  }
}

}  // namespace kestrel_slam
