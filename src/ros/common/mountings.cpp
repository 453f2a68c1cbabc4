// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/mountings.h"

#include "kestrel_slam/messages/conversions.h"

namespace kestrel {
namespace {

// tf arrives on the thread of the node: nothing is looked up while another thread adds frames.
constexpr bool kOwnTfThread = false;

}  // namespace

Mountings::Mountings(const ros::NodeHandle& nh, const std::string& base_frame)
    : base_frame_(base_frame), listener_(buffer_, nh, kOwnTfThread) {}

std::optional<Eigen::Isometry3d> Mountings::lookup(const std::string& sensor_frame) const {
  // tf2 knows no frame that nobody has published, not even its own identity.
  if (sensor_frame == base_frame_) return Eigen::Isometry3d::Identity();
  const ros::Time latest;  // sensors are bolted on
  if (!buffer_.canTransform(base_frame_, sensor_frame, latest)) return std::nullopt;
  return fromMessage(buffer_.lookupTransform(base_frame_, sensor_frame, latest).transform);
}

std::string Mountings::missing(const std::string& sensor, const std::string& sensor_frame) const {
  if (sensor_frame.empty()) {
    return "the frame_id of the " + sensor + " is empty; its driver has to set it";
  }
  return "no transform from the " + sensor + "'s frame '" + sensor_frame + "' to the base frame '" +
         base_frame_ +
         "'. The robot's description should publish it; where the two are the same, set "
         "~base_frame to '" +
         sensor_frame + "', else for example: rosrun tf2_ros static_transform_publisher " +
         "0 0 0 0 0 0 " + base_frame_ + " " + sensor_frame;
}

}  // namespace kestrel
