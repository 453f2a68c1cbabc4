// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "kestrel_slam/ros/mapper/graph_worker.h"

namespace kestrel {

/// The path of the keyframes, and lines between the keyframes of loops: accepted ones green,
/// pending ones yellow, refused ones red.
visualization_msgs::MarkerArray graphMarkers(const GraphView& graph, const std::string& map_frame,
                                             const ros::Time& stamp);

/// The paths of the finished submaps in different colors, with their numbers.
visualization_msgs::MarkerArray submapMarkers(const GraphView& graph, const std::string& map_frame,
                                              const ros::Time& stamp);

/// The loops that a search found, as text: the reason, fit, margin and correction of each.
visualization_msgs::MarkerArray loopMarkers(const GraphView& graph, const std::string& map_frame,
                                            const ros::Time& stamp);

}  // namespace kestrel
