// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/OccupancyGrid.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/TrackArray.h"
#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {

kestrel_slam::Track toMessage(const Track& track);

/// The tracks that are shown.
kestrel_slam::TrackArray toMessage(const Tracker::Result& result, const std::string& frame,
                                   const ros::Time& stamp);

/// A box, an arrow (where the object is in one second) and the id for each track.
visualization_msgs::MarkerArray toMarkers(const kestrel_slam::TrackArray& tracks);

sensor_msgs::PointCloud2 toCloud(const std::vector<Eigen::Vector3f>& points,
                                 const std::string& frame, const ros::Time& stamp);

/// The dynamic grid within `radius` (m) of `center`: 0 to 100, -1 where nothing is known.
nav_msgs::OccupancyGrid toMessage(const MotionGrid<2>& grid, const Eigen::Vector2d& center,
                                  double radius, const std::string& frame, const ros::Time& stamp);

}  // namespace kestrel
