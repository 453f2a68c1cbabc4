// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <algorithm>

#include "kestrel_slam/ros/common/stamps.h"

namespace kestrel {

/// Measures a waiting time. Uses the smaller value of ROS time and wall time. So a paused, slow or
/// fast replay does not cause a timeout.
class WaitingTime {
 public:
  double wallSeconds() const { return (ros::SteadyTime::now() - steady_start_).toSec(); }

  double seconds() const {
    const double steady = wallSeconds();
    const double ros = secondsBetween(ros_start_, ros::Time::now());
    return ros < 0.0 ? steady : std::min(steady, ros);  // negative: the clock was set back
  }

 private:
  ros::SteadyTime steady_start_ = ros::SteadyTime::now();
  ros::Time ros_start_ = ros::Time::now();
};

}  // namespace kestrel
