// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// True for the names that drivers use for the time of a point: time, t, timestamp, time_offset,
/// offset_time, time_stamp.
bool isPointTime(const std::string& name);

/// Sets the times of the points from the recorded numbers, one for each point. Drivers do not agree
/// on their meaning, so it is found from the numbers:
///
/// - Unit: `usual_unit` (s), unless a sweep would then be shorter or longer than any lidar needs.
///   Then it is the one of s, ms, µs and ns that gives the most usual duration.
/// - Zero: the stamp of the cloud, or that of the clock of `cloud.stamp` (absolute times). Times of
///   another clock, such as the time since the lidar was switched on, are counted from the first
///   point, which then has the time of the stamp.
///
/// If all numbers are equal, or no unit gives a possible sweep, all times stay 0, and
/// `cloud.time_problem` says why. Numbers of points without a return are ignored.
void setPointTimes(const std::vector<double>& values, double usual_unit, PointCloud& cloud);

}  // namespace kestrel
