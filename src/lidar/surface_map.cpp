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
/// Noise along the beams makes a line that wide, and its plane is that of the beams.
constexpr double kWidth_m = 0.05;

/// The direction of the smallest extent; none if the points do not form a plane.
void setPlane(const PointSums& sums, SurfaceCell& surface) {
  surface.normal.setZero();
  surface.thickness = 0.0F;
  if (sums.count < kNormalPoints) return;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(sums.spread / sums.count);
  const Eigen::Vector3d extents = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  if (extents(1) < kWidth_m || extents(0) > kFlatness * extents(1)) return;
  surface.normal = solver.eigenvectors().col(0).cast<float>();
  surface.thickness = static_cast<float>(extents(0));
}

}  // namespace

void SurfaceMap::add(const Voxels& voxels, const std::vector<Eigen::Vector3f>& ground) {
  std::vector<std::uint32_t> touched;
  for (std::size_t i = 0; i < voxels.index.size(); ++i) {
    const std::uint32_t number = table_.numberOf(voxels.index[i]);
    if (number == cells_.size()) {
      cells_.push_back({voxels.index[i], {}, 0.0});
      surfaces_.emplace_back();
    }
    cells_[number].sums.add(voxels.sums[i]);
    touched.push_back(number);
  }
  for (std::size_t i = 0; i < touched.size(); ++i) {
    update(touched[i], ground.empty() ? Eigen::Vector3f::Zero() : ground[i]);
  }
}

/// The cells of a voxel and of its neighbors.
std::vector<std::uint32_t> SurfaceMap::around(const GridIndex<3>& index) const {
  std::vector<std::uint32_t> numbers;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const std::uint32_t number = table_.find(index + GridIndex<3>(x, y, z));
        if (number != VoxelTable::kNone) numbers.push_back(number);
      }
    }
  }
  return numbers;
}

bool SurfaceMap::isNear(const Eigen::Vector3f& point) const {
  return !around(voxelIndexOf(point, resolution_)).empty();
}

/// Where the rings are far apart, a voxel has one of them, that is a line; its neighbors have the
/// next ones.
PointSums SurfaceMap::aroundOf(const Cell& cell) const {
  PointSums sums;
  for (const std::uint32_t number : around(cell.index)) sums.add(cells_[number].sums);
  return sums;
}

void SurfaceMap::update(std::size_t number, const Eigen::Vector3f& ground) {
  Cell& cell = cells_[number];
  SurfaceCell& surface = surfaces_[number];
  surface.mean = cell.sums.mean.cast<float>();
  if (cell.sums.count >= kGrowth * cell.count_of_normal) {
    setPlane(cell.sums, surface);
    if (surface.normal.isZero()) setPlane(aroundOf(cell), surface);
    if (surface.normal.isZero()) surface.normal = ground;
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
