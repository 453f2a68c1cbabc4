// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/beam_filter.h"
#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// Which beams see the vehicle's frame or the mirror; empty where there are none.
std::vector<bool> maskOf(const LaserScan& scan, const std::vector<AngleRange>& ignored,
                         const std::vector<AngleRange>& mirror);

/// Height of the base over the floor by the beams that a mirror bends to the base's -z: the median.
/// Nothing where there is no mirror, or fewer than three of its beams return.
std::optional<double> mirrorHeight(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                   const Eigen::Quaterniond& stabilized_R_base,
                                   const std::vector<AngleRange>& mirror,
                                   const ProjectorConfig& config);

}  // namespace kestrel
