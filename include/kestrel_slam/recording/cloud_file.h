// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// Reads one sweep of a 3D lidar from a file; its stamp is 0. Known are PCD (ascii or binary, with
/// or without padding after the points), and raw float32 numbers: `.pcd.bin` has five for a point
/// (nuScenes: x y z intensity ring), `.bin` four (KITTI: x y z intensity).
///
/// Throws std::runtime_error that names the file and what is wrong.
PointCloud readCloudFile(const std::string& path);

}  // namespace kestrel
