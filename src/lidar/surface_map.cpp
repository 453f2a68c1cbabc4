// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/surface_map.h"

#include <Eigen/Eigenvalues>
#include <cmath>
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
/// Perpendicular to the beams, so that a layer of beams is not infinitely thin.
constexpr double kBeamNoise_m = 0.005;

/// The direction of the smallest extent; none if the points do not form a plane.
///
/// The points scatter along the beams, because of the range and because surfaces are rough. Where
/// beams end at different depths, as in a hedge, a ring is a layer of points, which is thin and
/// along the beams: no surface can be seen so. The depth as a function of the direction
/// (regression) has another normal there, inverse(spread) * beam. The true plane lies between
/// them: with exact beams it is this one, with exact ranges that of the smallest extent. They agree
/// where the plane is not thicker than its inclination to the beams explains.
void setPlane(const PointSums& sums, const Eigen::Vector3d& beams, SurfaceCell& surface) {
  surface.normal.setZero();
  surface.tilt.setZero();
  surface.thickness = 0.0F;
  if (sums.count < kNormalPoints) return;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(sums.spread / sums.count);
  const Eigen::Vector3d extents = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  if (extents(1) < kWidth_m || extents(0) > kFlatness * extents(1)) return;
  const Eigen::Vector3d beam = solver.eigenvectors().transpose() * beams.normalized();
  const double across2 = extents(0) * extents(0) + kBeamNoise_m * kBeamNoise_m;
  Eigen::Vector3d turn = across2 * beam.array() / extents.array().square();
  turn(0) = 0.0;
  const double against = std::abs(beam(0));
  // Nearer to the beams than to the smallest extent, it is another plane.
  if (!(turn.norm() < against)) return;
  turn /= std::hypot(turn.norm(), against);
  surface.normal = solver.eigenvectors().col(0).cast<float>();
  surface.thickness = static_cast<float>(extents(0));
  surface.tilt = (solver.eigenvectors() * turn).cast<float>();
}

/// A surface may be seen from both sides.
void addBeams(const Eigen::Vector3d& more, Eigen::Vector3d& beams) {
  beams += beams.dot(more) < 0.0 ? (-more).eval() : more;
}

}  // namespace

void SurfaceMap::add(const Voxels& voxels, const Eigen::Vector3d& lidar,
                     const std::vector<Eigen::Vector3f>& ground) {
  std::vector<std::uint32_t> touched;
  for (std::size_t i = 0; i < voxels.index.size(); ++i) {
    const std::uint32_t number = table_.numberOf(voxels.index[i]);
    if (number == cells_.size()) {
      cells_.push_back({voxels.index[i], {}, Eigen::Vector3d::Zero(), 0.0});
      surfaces_.emplace_back();
    }
    cells_[number].sums.add(voxels.sums[i]);
    addBeams(voxels.sums[i].count * (voxels.sums[i].mean - lidar).normalized(),
             cells_[number].beams);
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
SurfaceMap::Cell SurfaceMap::aroundOf(const Cell& cell) const {
  Cell all{cell.index, {}, Eigen::Vector3d::Zero(), 0.0};
  for (const std::uint32_t number : around(cell.index)) {
    all.sums.add(cells_[number].sums);
    addBeams(cells_[number].beams, all.beams);
  }
  return all;
}

void SurfaceMap::update(std::size_t number, const Eigen::Vector3f& ground) {
  Cell& cell = cells_[number];
  SurfaceCell& surface = surfaces_[number];
  surface.mean = cell.sums.mean.cast<float>();
  if (cell.sums.count >= kGrowth * cell.count_of_normal) {
    setPlane(cell.sums, cell.beams, surface);
    if (surface.normal.isZero()) {
      const Cell all = aroundOf(cell);
      setPlane(all.sums, all.beams, surface);
    }
    if (surface.normal.isZero()) surface.normal = ground;
    cell.count_of_normal = cell.sums.count;
  }
  if (cell.sums.count <= kMostPoints) return;
  cell.sums.spread *= kMostPoints / cell.sums.count;
  cell.beams *= kMostPoints / cell.sums.count;
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
