// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include <vector>

#include "graph/loop_world.h"
#include "kestrel_slam/geometry/angles.h"
#include "room.h"

namespace kestrel {

/// A scan of a level laser between walls.
inline sensor_msgs::LaserScan messageAt(const Pose2& pose, const ros::Time& stamp,
                                        const std::vector<room::Segment>& walls) {
  constexpr int kBeams = 360;
  constexpr float kMaxRange = 30.0F;
  sensor_msgs::LaserScan scan;
  scan.header.stamp = stamp;
  scan.header.frame_id = "base_link";
  scan.angle_min = static_cast<float>(-kPi);
  scan.angle_increment = static_cast<float>(2.0 * kPi / kBeams);
  scan.angle_max = scan.angle_min + static_cast<float>(kBeams - 1) * scan.angle_increment;
  scan.range_max = kMaxRange;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = -kPi + 2.0 * kPi * i / kBeams;
    scan.ranges.push_back(static_cast<float>(room::cast(walls, pose, angle)));
  }
  return scan;
}

/// The same in the ring of corridors.
inline sensor_msgs::LaserScan messageAt(const Pose2& pose, const ros::Time& stamp) {
  static const std::vector<room::Segment> walls = loop_world::ring();
  return messageAt(pose, stamp, walls);
}

}  // namespace kestrel
