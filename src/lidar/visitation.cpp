// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/visitation.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/lidar/voxels.h"
#include "kestrel_slam/tracking/motion_grid.h"

namespace kestrel {
namespace {

/// Beams in one of these bins go through the same cells.
constexpr int kColumns = 720, kRows = 240;
constexpr float kTopRow = 1.0F;      ///< tangent of the elevation of the last row
constexpr double kCellMargin = 0.5;  ///< of a cell; cells at the border of the sector do not count

/// The directions of the beams with a return.
struct Beams {
  std::vector<bool> has_beam = std::vector<bool>(static_cast<std::size_t>(kColumns) * kRows);
  std::vector<bool> has_column = std::vector<bool>(kColumns);
  float lowest = kTopRow, highest = -kTopRow;  ///< tangents of the elevations
  std::vector<Eigen::Vector3f> directions;     ///< horizontal length 1, one for each bin

  void add(const Eigen::Vector3f& point);
};

std::size_t columnOf(float x, float y) {
  const float turn = std::atan2(y, x) / static_cast<float>(2.0 * kPi) + 0.5F;
  return static_cast<std::size_t>(turn * kColumns) % kColumns;
}

void Beams::add(const Eigen::Vector3f& point) {
  const float horizontal = point.head<2>().norm();
  if (!(horizontal > 0.0F)) return;
  const float tangent = point.z() / horizontal;
  if (std::abs(tangent) >= kTopRow) return;
  lowest = std::min(lowest, tangent);
  highest = std::max(highest, tangent);
  const std::size_t column = columnOf(point.x(), point.y());
  has_column[column] = true;
  const auto row = static_cast<std::size_t>((tangent / kTopRow + 1.0F) * 0.5F * kRows);
  const std::size_t bin = row * kColumns + column;
  if (has_beam[bin]) return;
  has_beam[bin] = true;
  directions.emplace_back(point / horizontal);
}

/// Cells around the lidar that beams have visited.
class VisitedCells {
 public:
  VisitedCells(const Eigen::Isometry3d& map_T_lidar, double radius, double height,
               double resolution)
      : resolution_(resolution) {
    const Eigen::Vector3d half(radius, radius, height);
    const Eigen::Vector3d at = map_T_lidar.translation();
    low_ = voxelIndexOf((at - half).cast<float>(), resolution);
    size_ = voxelIndexOf((at + half).cast<float>(), resolution) - low_ + GridIndex<3>::Ones();
    visited_.resize(static_cast<std::size_t>(size_.prod()));
  }

  void visit(const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
    const auto inverse = static_cast<float>(1.0 / resolution_);
    traverse<3>(from * inverse, to * inverse, [this](const GridIndex<3>& index) {
      const GridIndex<3> offset = index - low_;
      if ((offset.array() < 0).any() || (offset.array() >= size_.array()).any()) return false;
      visited_[slotOf(offset)] = true;
      return true;
    });
  }

  template <typename Use>
  void forEachUnvisited(Use use) const {
    GridIndex<3> offset;
    for (offset.z() = 0; offset.z() < size_.z(); ++offset.z()) {
      for (offset.y() = 0; offset.y() < size_.y(); ++offset.y()) {
        for (offset.x() = 0; offset.x() < size_.x(); ++offset.x()) {
          if (!visited_[slotOf(offset)]) use((offset + low_).eval());
        }
      }
    }
  }

 private:
  std::size_t slotOf(const GridIndex<3>& offset) const {
    return static_cast<std::size_t>((offset.z() * size_.y() + offset.y()) * size_.x() + offset.x());
  }

  double resolution_;
  GridIndex<3> low_, size_;
  std::vector<bool> visited_;
};

/// True if the whole cell lies in the sector that the lidar sees, and above the ground.
bool isInSector(const Eigen::Vector3f& center, const Beams& beams, const Ground& ground,
                float radius, float resolution) {
  const float horizontal = center.head<2>().norm();
  const float margin = resolution * static_cast<float>(kCellMargin);
  if (horizontal > radius - margin || horizontal < resolution) return false;
  if (!beams.has_column[columnOf(center.x(), center.y())]) return false;
  if ((center.z() - margin) / horizontal < beams.lowest) return false;
  if ((center.z() + margin) / horizontal > beams.highest) return false;
  const auto& plane = ground.planeAt(center);
  return !plane || plane->heightOf(center) > resolution;
}

}  // namespace

std::vector<GridIndex<3>> unvisitedCells(const std::vector<Eigen::Vector3f>& points,
                                         const Ground& ground, const Eigen::Isometry3d& map_T_lidar,
                                         const VisitationConfig& config) {
  Beams beams;
  for (const Eigen::Vector3f& point : points) beams.add(point);
  const double radius = std::min(config.max_radius_m, config.resolution_m / config.ring_step_rad);
  const double height =
      radius * static_cast<double>(std::max({-beams.lowest, beams.highest, 0.1F}));
  VisitedCells cells(map_T_lidar, radius, height, config.resolution_m);
  const Eigen::Isometry3f to_map = map_T_lidar.cast<float>();
  for (const Eigen::Vector3f& direction : beams.directions) {
    cells.visit(to_map.translation(), to_map * (direction * static_cast<float>(radius)));
  }
  std::vector<GridIndex<3>> unvisited;
  const Eigen::Isometry3f to_lidar = to_map.inverse();
  const auto resolution = static_cast<float>(config.resolution_m);
  cells.forEachUnvisited([&](const GridIndex<3>& index) {
    const Eigen::Vector3f center =
        to_lidar * ((index.cast<float>() + Eigen::Vector3f::Constant(0.5F)) * resolution).eval();
    if (isInSector(center, beams, ground, static_cast<float>(radius), resolution))
      unvisited.push_back(index);
  });
  return unvisited;
}

}  // namespace kestrel
