// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Range.h>

#include <optional>
#include <string>

#include "kestrel_slam/ros/common/mountings.h"
#include "kestrel_slam/ros/projector/projector_diagnostics.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/height_tracker.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {

/// The height of the vehicle over the floor: from a pose filter, from a range finder that looks
/// down, or from what the projector sees of the floor.
class HeightInput {
 public:
  HeightInput(ros::NodeHandle nh, const ProjectorNodeConfig& config, const Mountings& mountings,
              const AttitudeBuffer& attitude);

  /// Takes the heights that a projected sweep has measured.
  void add(const Projection& projection);

  /// Of the base over the floor at `time` (s), m; nothing where it is not known.
  std::optional<double> height(double time) const;

  /// Fills in the height's part of a report.
  void describe(ProjectorReport& report) const;

 private:
  void onFiltered(const sensor_msgs::RangeConstPtr& message);
  void onRange(const sensor_msgs::RangeConstPtr& message);

  std::string stabilized_frame_, footprint_frame_;
  const Mountings& mountings_;
  const AttitudeBuffer& attitude_;
  HeightTracker tracker_;
  double newest_ = 0.0;       ///< stamp of the newest reading or sweep, s
  bool is_unusable_ = false;  ///< what the range finder gave last
  ros::Subscriber subscriber_, filter_subscriber_;
};

}  // namespace kestrel
