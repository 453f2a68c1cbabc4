// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <string>

#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/ros/common/waiting_time.h"

namespace kestrel {

/// One sweep of a laser inside the projector node.
struct Sweep {
  std::string topic;
  std::string frame;  ///< of the laser, without a leading slash
  ros::Time stamp;
  SweepData data;
  SweepTimes times;  ///< times that the attitude must cover
  WaitingTime waiting;
};

}  // namespace kestrel
