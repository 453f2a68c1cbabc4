// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace kestrel {

/// An object of a label file of the KITTI tracking benchmark, in the frame of the lidar.
struct KittiLabel {
  long frame = 0, id = 0;
  std::string type;  ///< Car, Van, Pedestrian, ...
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< length, width, height, m
  double yaw = 0.0;                                ///< rad
};

/// camera_T_lidar: the rectification and `Tr_velo_cam` of a calibration file of KITTI.
/// Throws std::runtime_error with the file and what is missing.
Eigen::Isometry3d readKittiCalibration(const std::string& path);

/// Without a calibration: the camera looks along x of the lidar, from the same place.
Eigen::Isometry3d plainKittiCamera();

/// Reads a label file of the KITTI tracking benchmark, without `DontCare`. Throws
/// std::runtime_error with the file, the line and the error.
std::vector<KittiLabel> readKittiLabels(const std::string& path,
                                        const Eigen::Isometry3d& camera_T_lidar);

/// One line of such a file for an object. The box in the image is not known (-1).
std::string kittiLine(const KittiLabel& label, const Eigen::Isometry3d& camera_T_lidar);

}  // namespace kestrel
