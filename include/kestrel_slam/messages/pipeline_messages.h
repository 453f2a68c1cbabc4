// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <string>

#include "kestrel_slam/FilteredMotion.h"
#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/pipeline/filtered_motion.h"
#include "kestrel_slam/pipeline/matched_pose.h"

namespace kestrel {

// The messages between the nodes of the pipeline. Values are not rounded, so that the nodes and the
// offline run compute the same result. `stamp` is the stamp of the sensor message.

kestrel_slam::FilteredMotion toMessage(const FilteredMotion& motion, const ros::Time& stamp,
                                       const std::string& odom_frame);
/// Does not check values. FilteredMotionBuffer::add rejects values that are not finite.
FilteredMotion fromMessage(const kestrel_slam::FilteredMotion& message);

kestrel_slam::MapperState toMessage(const MatchedPose& pose, const ros::Time& stamp,
                                    const std::string& map_frame);
/// An unknown state is converted to "lost".
MatchedPose fromMessage(const kestrel_slam::MapperState& message);

}  // namespace kestrel
