// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/kitti_labels.h"

#include <cmath>
#include <iomanip>
#include <istream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

/// The name of a matrix without a colon, and its numbers.
std::optional<std::vector<double>> numbersAfter(const std::string& line, const std::string& name) {
  std::istringstream fields(line);
  std::string key;
  fields >> key;
  if (!key.empty() && key.back() == ':') key.pop_back();
  if (key != name) return std::nullopt;
  std::vector<double> numbers;
  for (double value = 0.0; fields >> value;) numbers.push_back(value);
  return numbers;
}

KittiLabel labelOf(const std::string& line, const Eigen::Isometry3d& lidar_T_camera) {
  std::istringstream fields(line);
  KittiLabel label;
  double unused = 0.0, height = 0.0, width = 0.0, length = 0.0, turn = 0.0;
  fields >> label.frame >> label.id >> label.type;
  for (int i = 0; i < 7; ++i) fields >> unused;  // truncated, occluded, alpha, box in the image
  Eigen::Vector3d bottom;
  fields >> height >> width >> length >> bottom.x() >> bottom.y() >> bottom.z() >> turn;
  if (!fields) throw std::runtime_error("expected 17 fields of the KITTI tracking benchmark");
  label.size << length, width, height;
  label.center = lidar_T_camera * (bottom - Eigen::Vector3d(0.0, 0.5 * height, 0.0));
  // The turn is about y of the camera, which points down.
  const Eigen::Vector3d along =
      lidar_T_camera.linear() * Eigen::Vector3d(std::cos(turn), 0.0, -std::sin(turn));
  label.yaw = std::atan2(along.y(), along.x());
  return label;
}

}  // namespace

Eigen::Isometry3d plainKittiCamera() {
  Eigen::Isometry3d camera_T_lidar = Eigen::Isometry3d::Identity();
  camera_T_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return camera_T_lidar;
}

Eigen::Isometry3d readKittiCalibration(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  Eigen::Matrix3d rectification = Eigen::Matrix3d::Identity();
  std::optional<Eigen::Isometry3d> transform;
  std::string line;
  while (readLine(*stream, line)) {
    const auto rectified = numbersAfter(line, "R_rect");
    if (rectified && rectified->size() == 9) {
      rectification =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rectified->data());
    }
    const auto matrix = numbersAfter(line, "Tr_velo_cam");
    if (!matrix || matrix->size() != 12) continue;
    transform = Eigen::Isometry3d::Identity();
    transform->matrix().topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(matrix->data());
  }
  if (!transform) {
    throw std::runtime_error(path +
                             ": has no Tr_velo_cam with 12 numbers; give the calibration "
                             "file of the KITTI tracking benchmark");
  }
  Eigen::Isometry3d result = *transform;
  result.linear() = rectification * transform->linear();
  result.translation() = rectification * transform->translation();
  return result;
}

std::vector<KittiLabel> readKittiLabels(const std::string& path,
                                        const Eigen::Isometry3d& camera_T_lidar) {
  const std::unique_ptr<std::istream> stream = openText(path);
  const Eigen::Isometry3d lidar_T_camera = camera_T_lidar.inverse();
  std::vector<KittiLabel> labels;
  std::string line;
  for (std::size_t number = 1; readLine(*stream, line); ++number) {
    if (line.empty()) continue;
    try {
      const KittiLabel label = labelOf(line, lidar_T_camera);
      if (label.type != "DontCare") labels.push_back(label);
    } catch (const std::exception& error) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return labels;
}

std::string kittiLine(const KittiLabel& label, const Eigen::Isometry3d& camera_T_lidar) {
  const Eigen::Vector3d bottom =
      camera_T_lidar * label.center + Eigen::Vector3d(0.0, 0.5 * label.size.z(), 0.0);
  const Eigen::Vector3d along =
      camera_T_lidar.linear() * Eigen::Vector3d(std::cos(label.yaw), std::sin(label.yaw), 0.0);
  const double turn = std::atan2(-along.z(), along.x());
  const double alpha = normalizeAngle(turn - std::atan2(bottom.x(), bottom.z()));
  std::ostringstream out;
  out << std::fixed << std::setprecision(4) << label.frame << ' ' << label.id << ' ' << label.type
      << " -1 -1 " << alpha << " -1 -1 -1 -1 " << label.size.z() << ' ' << label.size.y() << ' '
      << label.size.x() << ' ' << bottom.x() << ' ' << bottom.y() << ' ' << bottom.z() << ' '
      << turn << " 1\n";
  return out.str();
}

}  // namespace kestrel
