// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/mountings.h"

#include <utility>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/ros/common/names.h"

namespace kestrel {

Mountings::Mountings(const ros::NodeHandle& nh, const std::string& base_frame,
                     std::vector<OwnTransform> own)
    : base_frame_(base_frame), input_(buffer_, nh, std::move(own)) {}

std::optional<Eigen::Isometry3d> Mountings::lookup(const std::string& sensor_frame) const {
  // tf2 rejects frames that were never published, even for an identity transform.
  if (sensor_frame == base_frame_) return Eigen::Isometry3d::Identity();
  const ros::Time latest;  // time zero means the latest transform; mountings are fixed
  if (!buffer_.canTransform(base_frame_, sensor_frame, latest)) return std::nullopt;
  return fromMessage(buffer_.lookupTransform(base_frame_, sensor_frame, latest).transform);
}

std::string Mountings::missing(const std::string& sensor, const std::string& frame) const {
  const std::string sensor_frame = clippedName(frame);
  if (sensor_frame.empty()) {
    return "the frame_id of the " + sensor + " is empty; the sensor driver must set it";
  }
  return "no transform from the " + sensor + "'s frame '" + sensor_frame + "' to the base frame '" +
         base_frame_ + "'. Publish it (rosrun tf2_ros static_transform_publisher 0 0 0 0 0 0 " +
         base_frame_ + " " + sensor_frame + "), or set ~base_frame";
}

}  // namespace kestrel
