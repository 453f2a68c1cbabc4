// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Range.h>

#include <optional>
#include <string>

#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/ros/common/range_mounting.h"
#include "kestrel_slam/ros/projector/projector_diagnostics.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"

namespace kestrel {

/// Receives the readings of a range finder that points down and passes them to the projection.
class HeightInput {
 public:
  HeightInput(ros::NodeHandle nh, const ProjectorNodeConfig& config, const Mountings& mountings,
              ProjectionStage& projection);

  /// Fills in the height part of a report. `time` (s): time of the reported height.
  void describe(double time, ProjectorReport& report) const;

 private:
  void onRange(const sensor_msgs::RangeConstPtr& message);

  std::string stabilized_frame_, footprint_frame_;
  RangeMounting mounting_;
  ProjectionStage& projection_;
  bool is_unusable_ = false;  ///< the last reading of the range finder was not used
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
