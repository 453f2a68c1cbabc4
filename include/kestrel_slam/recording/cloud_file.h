// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// Reads one sweep of a 3D lidar from a file; its stamp is 0. Formats: PCD (ascii or binary, with
/// or without padding after the points) and raw float32 numbers. A `.pcd.bin` file has five numbers
/// per point (nuScenes: x y z intensity ring), a `.bin` file has four (KITTI: x y z intensity).
///
/// Throws std::runtime_error with the name of the file and the error.
PointCloud readCloudFile(const std::string& path);

}  // namespace kestrel
