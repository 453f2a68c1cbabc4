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

  /// The frames above `frame`, nearest first.
  std::vector<std::string> ancestors(const std::string& frame) const;

  /// The frame of the vehicle: base_link where tf knows it, otherwise the highest frame above the
  /// sensor that does not belong to the world.
  std::string vehicleFrame(const std::string& sensor_frame) const;

  /// `target_T_source` at a time, or at any time where nothing between the two ever moves.
  std::optional<Eigen::Isometry3d> lookup(const std::string& target, const std::string& source,
                                          const ros::Time& time) const;

  /// Whether tf has a path between the frames at all, whatever the time.
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
  std::size_t bad_ = 0;                ///< with NaN, without a frame, or to itself
};

}  // namespace kestrel
