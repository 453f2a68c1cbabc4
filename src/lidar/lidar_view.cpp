// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr float kBehind = 0.5F;      ///< m; a beam that ends nearer may end there
constexpr int kAcross = 5, kUp = 3;  ///< places of an object that are looked at

/// In turns, from 0 to 1. A polynomial with an error of 1e-3 rad: 115 000 points in 1 ms.
float turnOf(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float ratio = std::min(ax, ay) / std::max({ax, ay, 1e-9F});
  float angle = ratio * (0.9724F - 0.1919F * ratio * ratio);
  if (ay > ax) angle = static_cast<float>(0.5 * kPi) - angle;
  if (x < 0.0F) angle = static_cast<float>(kPi) - angle;
  if (y < 0.0F) angle = -angle;
  return angle / static_cast<float>(2.0 * kPi) + 0.5F;
}

}  // namespace

LidarView::LidarView(const std::vector<Eigen::Vector3f>& points,
                     const Eigen::Isometry3d& map_T_lidar)
    : to_lidar_(map_T_lidar.inverse().cast<float>()),
      lidar_(map_T_lidar.translation()),
      reach_(static_cast<std::size_t>(kColumns) * kRows, -1.0F),
      has_column_(kColumns) {
  std::vector<float> tangents;
  tangents.reserve(points.size());
  float highest = -1e9F;
  lowest_ = 1e9F;
  for (const Eigen::Vector3f& point : points) {
    const float tangent = point.z() / std::max(point.head<2>().norm(), 0.1F);
    tangents.push_back(tangent);
    lowest_ = std::min(lowest_, tangent);
    highest = std::max(highest, tangent);
  }
  step_ = std::max((highest - lowest_) / (kRows - 1), 1e-6F);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto column =
        static_cast<std::size_t>(turnOf(points[i].y(), points[i].x()) * kColumns) % kColumns;
    const auto row = static_cast<std::size_t>((tangents[i] - lowest_) / step_);
    has_column_[column] = true;
    float& reach = reach_[row * kColumns + column];
    reach = std::max(reach, points[i].norm());
  }
}

/// The farthest return in the direction of a place; negative: none, nothing: it is out of view.
std::optional<float> LidarView::reachTo(const Eigen::Vector3f& in_lidar) const {
  const auto column =
      static_cast<std::size_t>(turnOf(in_lidar.y(), in_lidar.x()) * kColumns) % kColumns;
  if (!has_column_[column]) return std::nullopt;
  const float tangent = in_lidar.z() / std::max(in_lidar.head<2>().norm(), 0.1F);
  const float row = (tangent - lowest_) / step_;
  if (row < 0.0F || row >= static_cast<float>(kRows)) return std::nullopt;
  return reach_[static_cast<std::size_t>(row) * kColumns + column];
}

bool LidarView::isVisible(const Eigen::Vector3f& in_lidar, float margin) const {
  const std::optional<float> reach = reachTo(in_lidar);
  return reach && (*reach < 0.0F || *reach >= in_lidar.norm() - margin);
}

bool LidarView::isPassed(const Eigen::Vector3d& place) const {
  const Eigen::Vector3f in_lidar = to_lidar_ * place.cast<float>();
  const std::optional<float> reach = reachTo(in_lidar);
  return reach && *reach >= in_lidar.norm() + kBehind;
}

double LidarView::visibleShare(const Eigen::Vector3d& center, double width, double height) const {
  const Eigen::Vector3f middle = to_lidar_ * center.cast<float>();
  const Eigen::Vector3f along(middle.x(), middle.y(), 0.0F);
  const Eigen::Vector3f across =
      Eigen::Vector3f(-along.y(), along.x(), 0.0F) / std::max(along.norm(), 0.1F);
  int visible = 0;
  for (int i = 0; i < kAcross; ++i) {
    for (int j = 0; j < kUp; ++j) {
      const auto aside = static_cast<float>(width * (i / (kAcross - 1.0) - 0.5) * 0.9);
      const auto up = static_cast<float>(height * (j / (kUp - 1.0) - 0.5) * 0.8);
      const Eigen::Vector3f place = middle + aside * across + up * Eigen::Vector3f::UnitZ();
      if (isVisible(place, static_cast<float>(width + 0.2))) ++visible;
    }
  }
  return static_cast<double>(visible) / (kAcross * kUp);
}

}  // namespace kestrel
