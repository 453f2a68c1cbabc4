// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <functional>

#include "kestrel_slam/FilteredMotion.h"
#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"

namespace kestrel {

/// Receives the states of a pose filter and passes them to the projection.
class FilterInput {
 public:
  /// `on_state` is called with the stamp of every used state.
  FilterInput(ros::NodeHandle nh, const ProjectorNodeConfig& config, ProjectionStage& projection,
              std::function<void(const ros::Time&)> on_state);

 private:
  void onMotion(const kestrel_slam::FilteredMotionConstPtr& message);

  ProjectionStage& projection_;
  std::function<void(const ros::Time&)> on_state_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
