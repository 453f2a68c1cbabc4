// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "kestrel_slam/sensor/planar_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// Writes a PNG with a slice and the cloud that it was extracted from, seen from above, up to
/// `radius_m` around the vehicle. Throws std::runtime_error with the name of the file if it cannot
/// be written.
void writeSlicePlot(const std::string& path, const std::string& title, const PointCloud& cloud,
                    const Eigen::Isometry3d& base_T_lidar, const PlanarScan& slice,
                    double radius_m);

}  // namespace kestrel
