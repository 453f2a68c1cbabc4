// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/surface_map.h"

#include <Eigen/Eigenvalues>
#include <utility>

namespace kestrel {
namespace {

/// A voxel does not count more points than these: so it follows slow changes and the sums stay
/// exact.
constexpr double kMostPoints = 2000.0;
constexpr double kNormalPoints = 8.0;  ///< for a normal
constexpr double kGrowth = 1.2;        ///< the normal is computed again after so many more points
/// A plane is at most this thick compared with its smaller extent. A single ring on a wall is a
/// line and has no normal.
constexpr double kFlatness = 0.25;

/// The direction of the smallest extent; zero if the points do not form a plane.
Eigen::Vector3f normalOf(const PointSums& sums) {
  if (sums.count < kNormalPoints) return Eigen::Vector3f::Zero();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(sums.spread / sums.count);
  const Eigen::Vector3d extents = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  if (extents(0) > kFlatness * extents(1)) return Eigen::Vector3f::Zero();
  return solver.eigenvectors().col(0).cast<float>();
}

}  // namespace

void SurfaceMap::add(const Voxels& voxels, const std::vector<bool>& use) {
  for (std::size_t i = 0; i < voxels.index.size(); ++i) {
    if (!use[i]) continue;
    const std::uint32_t number = table_.numberOf(voxels.index[i]);
    if (number == cells_.size()) {
      cells_.push_back({voxels.index[i], {}, 0.0});
      surfaces_.emplace_back();
    }
    cells_[number].sums.add(voxels.sums[i]);
    update(number);
  }
}

void SurfaceMap::update(std::size_t number) {
  Cell& cell = cells_[number];
  SurfaceCell& surface = surfaces_[number];
  surface.mean = cell.sums.mean.cast<float>();
  if (cell.sums.count >= kGrowth * cell.count_of_normal) {
    surface.normal = normalOf(cell.sums);
    cell.count_of_normal = cell.sums.count;
  }
  if (cell.sums.count <= kMostPoints) return;
  cell.sums.spread *= kMostPoints / cell.sums.count;
  cell.sums.count = kMostPoints;
  cell.count_of_normal = kMostPoints / kGrowth;
}

void SurfaceMap::forgetFar(const Eigen::Vector3d& position, double radius) {
  std::vector<Cell> kept;
  std::vector<SurfaceCell> kept_surfaces;
  VoxelTable table(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    if ((cells_[i].sums.mean - position).norm() > radius) continue;
    table.numberOf(cells_[i].index);
    kept.push_back(cells_[i]);
    kept_surfaces.push_back(surfaces_[i]);
  }
  table_ = std::move(table);
  cells_ = std::move(kept);
  surfaces_ = std::move(kept_surfaces);
}

std::size_t SurfaceMap::memoryBytes() const {
  return table_.memoryBytes() + cells_.capacity() * sizeof(Cell) +
         surfaces_.capacity() * sizeof(SurfaceCell);
}

}  // namespace kestrel
