// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <functional>
#include <optional>
#include <string>

#include "kestrel_slam/ros/common/silence_watch.h"
#include "kestrel_slam/ros/mapper/scan_statistics.h"

namespace kestrel {

/// Loops of the pose graph.
struct LoopCounts {
  int closed = 0;
  int refused = 0;
};

/// Size of the map, and its loops, for the diagnostics.
struct MapSize {
  int width = 0;  ///< cells
  int height = 0;
  double resolution_m = 0.0;
  std::size_t memory_bytes = 0;
  std::optional<LoopCounts> loops;  ///< of a pose graph
};

/// Publishes /diagnostics: three items for the scans, the match and the map.
///
/// Uses a wall timer, so that a paused or finished replay is still reported.
class Diagnostics {
 public:
  /// `nh`: the timer runs on its queue. `topic_parameter`: the parameter with the name of
  /// `scan_topic`. `publisher_count`: returns the number of its publishers.
  Diagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh,
              const NeededTopic& scan_topic, const std::string& topic_parameter,
              ScanStatistics& statistics, std::function<unsigned()> publisher_count,
              std::function<MapSize()> map_size, std::function<bool()> is_localizing);

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void look();
  void update();
  void fillScans(Status& status) const;
  void fillMatch(Status& status) const;
  void fillMap(Status& status) const;
  std::string checkSilence();

  std::string scan_topic_;
  ScanStatistics& statistics_;
  std::function<unsigned()> publisher_count_;
  std::function<MapSize()> map_size_;
  std::function<bool()> is_localizing_;
  SilenceWatch watch_;
  std::string silence_;  ///< why there are no scans; empty if scans arrive
  ScanReport report_;
  ros::WallTime started_ = ros::WallTime::now();
  ros::WallTime updated_;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace kestrel
