// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/beam_filter.h"
#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// True for each beam that hits the frame of the vehicle or a mirror. Empty if neither is
/// configured.
std::vector<bool> maskOf(const LaserScan& scan, const std::vector<AngleRange>& ignored,
                         const std::vector<AngleRange>& mirror);

/// Height of the base over the floor, m: the median over the beams that a mirror deflects along the
/// -z axis of the base. Nothing if there is no mirror or if fewer than three of its beams return.
std::optional<double> mirrorHeight(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                   const Eigen::Quaterniond& stabilized_R_base,
                                   const std::vector<AngleRange>& mirror,
                                   const ProjectorConfig& config);

}  // namespace kestrel
