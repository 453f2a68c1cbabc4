// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/ros/projector/projector_statistics.h"
#include "kestrel_slam/ros/projector/sweep.h"

namespace kestrel {

/// Receives the sweeps of all lasers. Unusable sweeps are counted, and the reason is logged.
class SweepInput {
 public:
  using Callback = std::function<void(Sweep)>;

  SweepInput(ros::NodeHandle nh, const ProjectorNodeConfig& config, ProjectorStatistics& statistics,
             Callback on_sweep);

  std::string topics() const;
  unsigned publisherCount() const;

 private:
  void onScan(const sensor_msgs::LaserScanConstPtr& message, const std::string& topic);
  void onCloud(const sensor_msgs::PointCloud2ConstPtr& message, const std::string& topic);
  bool accept(const std_msgs::Header& header, const std::string& topic);
  void refuse(const std::string& topic, const std::string& reason, const std::string& sentence);
  void pass(Sweep sweep, const std_msgs::Header& header, const std::string& topic);

  std::size_t max_beams_;
  ProjectorStatistics& statistics_;
  Callback on_sweep_;
  std::map<std::string, ros::Time> last_stamps_;  ///< by topic
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace kestrel
