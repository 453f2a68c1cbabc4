// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tf2/buffer_core.h>

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/recording/bag/bag_files.h"

namespace kestrel {

/// All transforms of a bag, static and dynamic.
class BagTransforms {
 public:
  /// Reads every TFMessage on a topic `tf` or `tf_static`.
  explicit BagTransforms(const BagFiles& files);

  bool empty() const { return edges_.empty(); }
  bool knows(const std::string& frame) const;

  /// The ancestors of `frame`, beginning with its parent.
  std::vector<std::string> ancestors(const std::string& frame) const;

  /// The frame of the vehicle on which the sensor is mounted: its ancestor called base_link, with
  /// or without a namespace; otherwise the topmost frame that is rigidly connected to the sensor.
  /// (The frames above that one, such as odom and map, move relative to the vehicle.) If tf does
  /// not have the sensor: base_link if tf has it, otherwise the frame of the sensor.
  std::string vehicleFrame(const std::string& sensor_frame) const;

  /// `target_T_source` at `time`. The time is ignored if the transform is the same at all times.
  std::optional<Eigen::Isometry3d> lookup(const std::string& target, const std::string& source,
                                          const ros::Time& time) const;

  /// True if tf connects the two frames at any time.
  bool connected(const std::string& a, const std::string& b) const;

  /// Names of all frames, for messages.
  std::string listFrames() const;
  /// The transform above `frame` by which another program has localized it in a map, as
  /// "map -> odom"; "" if there is none.
  std::string localizationOf(const std::string& frame) const;
  /// The stamp of the first transform that is not static, s.
  std::optional<double> firstStamp() const { return first_stamp_; }

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
  std::optional<double> first_stamp_;
  std::size_t bad_ = 0;  ///< invalid transforms, which are ignored
};

}  // namespace kestrel
