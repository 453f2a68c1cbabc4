// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/bag.h>
#include <tf2/buffer_core.h>

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// All transforms of a bag, static and dynamic.
class BagTransforms {
 public:
  /// Reads every TFMessage on a topic `tf` or `tf_static`.
  explicit BagTransforms(const rosbag::Bag& bag);

  bool empty() const { return edges_.empty(); }
  bool knows(const std::string& frame) const;

  /// The ancestors of `frame`, beginning with its parent.
  std::vector<std::string> ancestors(const std::string& frame) const;

  /// The frame of the vehicle: base_link if tf has it, otherwise the topmost ancestor of the sensor
  /// that is not a world frame (such as map or odom).
  std::string vehicleFrame(const std::string& sensor_frame) const;

  /// `target_T_source` at `time`. The time is ignored if the transform is the same at all times.
  std::optional<Eigen::Isometry3d> lookup(const std::string& target, const std::string& source,
                                          const ros::Time& time) const;

  /// True if tf connects the two frames at any time.
  bool connected(const std::string& a, const std::string& b) const;

  std::size_t badTransforms() const { return bad_; }

 private:
  struct Edge {
    std::string parent;
    Eigen::Isometry3d first;
    bool rigid = true;
  };

  void add(const geometry_msgs::TransformStamped& transform, bool is_static);
  bool rigid(const std::string& a, const std::string& b) const;

  tf2::BufferCore buffer_;
  std::map<std::string, Edge> edges_;  ///< by child frame
  std::size_t bad_ = 0;                ///< invalid transforms, which are ignored
};

}  // namespace kestrel
