// SPDX-License-Identifier: BSD-3-Clause
#include <nodelet/nodelet.h>
#include <ros/console.h>

#include <exception>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "kestrel_slam/ros/filter/pose_filter_node.h"
#include "kestrel_slam/ros/mapper/mapper_node.h"
#include "kestrel_slam/ros/projector/scan_projector_node.h"
#include "kestrel_slam/ros/tracker/tracker_node.h"

namespace kestrel {

/// Runs a node inside a nodelet manager. Messages between nodelets are passed by pointer. The node
/// handles of a nodelet are served by one thread at a time, as the nodes require.
template <typename Node>
class NodeletOf : public nodelet::Nodelet {
 private:
  /// An exception makes the manager refuse this nodelet and continue. The manager does not log the
  /// reason, so it is logged here.
  void onInit() override {
    try {
      node_ = std::make_unique<Node>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      ROS_FATAL("%s cannot run: %s", getName().c_str(), error.what());
      throw;
    }
  }

  std::unique_ptr<Node> node_;
};

class ScanProjectorNodelet : public NodeletOf<ScanProjectorNode> {};
class MapperNodelet : public NodeletOf<MapperNode> {};
class PoseFilterNodelet : public NodeletOf<PoseFilterNode> {};
class TrackerNodelet : public NodeletOf<TrackerNode> {};

}  // namespace kestrel

PLUGINLIB_EXPORT_CLASS(kestrel::ScanProjectorNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(kestrel::MapperNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(kestrel::PoseFilterNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(kestrel::TrackerNodelet, nodelet::Nodelet)
