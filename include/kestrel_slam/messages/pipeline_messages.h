// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <string>

#include "kestrel_slam/FilteredMotion.h"
#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/pipeline/filtered_motion.h"
#include "kestrel_slam/pipeline/matched_pose.h"

namespace kestrel {

// What the nodes of the pipeline tell each other. Nothing is rounded, so that nodes and offline run
// compute the same. `stamp` is that of the sensor's message.

kestrel_slam::FilteredMotion toMessage(const FilteredMotion& motion, const ros::Time& stamp,
                                       const std::string& odom_frame);
/// Values that are not finite are passed on; FilteredMotionBuffer::add refuses them.
FilteredMotion fromMessage(const kestrel_slam::FilteredMotion& message);

kestrel_slam::MapperState toMessage(const MatchedPose& pose, const ros::Time& stamp,
                                    const std::string& map_frame);
/// An unknown state is taken for "lost".
MatchedPose fromMessage(const kestrel_slam::MapperState& message);

}  // namespace kestrel
