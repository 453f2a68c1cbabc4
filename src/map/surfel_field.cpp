// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/surfel_field.h"

#include <algorithm>
#include <cmath>

#include "nearest_row.h"
#include "wall_tangent.h"

namespace kestrel {
namespace {

/// Number of hits after which the mean of a cell forgets old ones, so that it can follow a moved
/// wall. Chosen from 15 and 30: smaller worst error in the perturbed runs of intel.
constexpr float kMaxCount = 15.0F;
/// The line of a wall is computed from the neighbors within this many cells: 0.25 m at 5 cm.
constexpr int kShapeRadius = 2;
/// In cells. If a mean of many hits moves less than this, its line is not updated.
constexpr float kMinShift = 0.05F;
/// A line needs this many cells, and this ratio of the standard deviations along and across it.
constexpr int kMinShapeCells = 3;
/// Neighbors up to this distance along a wall take part in its position, in cells. Farther ones
/// would flatten round objects.
constexpr float kAlignReach = 1.0F;
constexpr float kMinElongation = 2.0F;
constexpr auto kDiskHalfWidths = halfWidthsOfDisk<SurfelField::kReachCells>();

int diskHalfWidth(int dy) {
  return kDiskHalfWidths[static_cast<std::size_t>(dy + SurfelField::kReachCells)];
}

void setLine(Surfel& surfel, const Eigen::Vector2f& t2) {
  const Eigen::Vector3f shape = lineShape(t2);
  surfel.a11 = shape.x(), surfel.a12 = shape.y(), surfel.a22 = shape.z();
}

}  // namespace

const Surfel SurfelField::kZeros{
    Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), 0.0F, 0.0F, 0.0F, {}};

SurfelField::SurfelField(float resolution_m, const SharedBudget& budget)
    : resolution_(resolution_m),
      inverse_resolution_(1.0F / resolution_m),
      budget_(budget),
      tiles_(budget) {}

void SurfelField::clear() {
  tiles_.clear();
  budget_->giveBack(surfels_.capacity() * sizeof(Surfel));
  surfels_ = {};
  free_.clear();
}

std::vector<Surfel> SurfelField::surfelsIn(const Eigen::AlignedBox2f& area) const {
  std::vector<Surfel> result;
  tiles_.forEach([&](const Cell& corner, const Tile& tile) {
    const Eigen::Vector2f low =
        Eigen::Vector2f(static_cast<float>(corner.x), static_cast<float>(corner.y)) * resolution_;
    const Eigen::Vector2f high = low.array() + kTileSide * resolution_;
    if (!area.intersects(Eigen::AlignedBox2f(low, high))) return;
    for (std::size_t row = 0; row < kTileSide; ++row) {
      for (std::uint32_t bits = tile.own[row]; bits != 0U; bits &= bits - 1U) {
        const auto column = static_cast<std::size_t>(__builtin_ctz(bits));
        const Surfel& surfel = surfels_[tile.nearest[row * kTileSide + column]];
        if (area.contains(surfel.mean)) result.push_back(surfel);
      }
    }
  });
  return result;
}

bool SurfelField::update(const OccupancyGrid& grid, const OccupancyGrid::Changes& changes,
                         std::uint32_t number) {
  full_ = false;
  number_ = number;
  for (const Cell& cell : changes.became_free) remove(cell);
  changed_.clear();
  for (std::size_t i = 0; i < changes.hits.size(); ++i) {
    if (!grid.isOccupied(changes.hits[i].cell)) continue;
    bool sparse = false;
    const Eigen::Vector2f tangent2 = tangentAt(changes.hits, i, sparse);
    addHit(changes.hits[i], tangent2, sparse);
  }
  moved_.clear();
  for (const std::uint32_t id : changed_) {
    if (addMean(id)) moved_.push_back(id);
  }
  for (const std::uint32_t id : moved_) {
    updateShape(id);
    align(id);
  }
  return !full_;
}

std::uint32_t SurfelField::idAt(const Cell& cell) const {
  const Tile* tile = tiles_.find(cell);
  if (tile == nullptr) return kNone;
  const std::size_t offset = offsetInTile(cell);
  return tile->distance2[offset] == 0 ? tile->nearest[offset] : kNone;
}

void SurfelField::setOwn(const Cell& cell, bool own) {
  Tile* tile = tiles_.find(cell);
  if (tile == nullptr) return;
  std::uint32_t& row = tile->own[offsetInTile(cell) >> kTileShift];
  const std::uint32_t bit = 1U << (static_cast<unsigned>(cell.x) & (kTileSide - 1U));
  row = own ? row | bit : row & ~bit;
}

/// Calls `visit(id)` for every surfel in the square of `radius` cells around `center`, row by row.
template <typename Visit>
void SurfelField::forEachOwn(const Cell& center, int radius, Visit visit) const {
  const int x0 = center.x - radius, x1 = center.x + radius;
  for (int y = center.y - radius; y <= center.y + radius; ++y) {
    for (int corner = x0 & ~(kTileSide - 1); corner <= x1; corner += kTileSide) {
      const Tile* tile = tiles_.find({corner, y});
      if (tile == nullptr) continue;
      const std::size_t row = offsetInTile({corner, y});
      std::uint32_t bits = tile->own[row >> kTileShift];
      if (corner < x0) bits &= ~0U << (x0 - corner);
      if (corner + kTileSide - 1 > x1) bits &= ~0U >> (corner + kTileSide - 1 - x1);
      for (; bits != 0U; bits &= bits - 1U) {
        visit(tile->nearest[row + static_cast<std::size_t>(__builtin_ctz(bits))]);
      }
    }
  }
}

void SurfelField::addHit(const OccupancyGrid::Changes::Hit& hit, const Eigen::Vector2f& tangent2,
                         bool sparse) {
  std::uint32_t id = idAt(hit.cell);
  if (id == kNone) id = create(hit);
  if (id == kNone) return;
  Surfel& surfel = surfels_[id];
  if (surfel.new_hits == 0.0F) changed_.push_back(id);
  surfel.new_hits += 1.0F;
  surfel.new_sum += hit.point - surfel.mean;
  (sparse ? surfel.sparse2 : surfel.tangent2) += tangent2;
}

/// Creates a surfel without hits in the cell of `hit`. Returns kNone at the memory limit.
std::uint32_t SurfelField::create(const OccupancyGrid::Changes::Hit& hit) {
  // A surfel that is not stored in its own cell cannot be found, and the next hit adds another.
  Tile* tile = hasRoom() ? tiles_.obtain(hit.cell) : nullptr;
  if (tile == nullptr) {
    full_ = true;
    return kNone;
  }
  Surfel surfel{hit.point, hit.point, 1.0F, 0.0F, 1.0F, hit.cell};
  surfel.birth = number_;
  surfel.appeared = hit.in_free && !isAtWall(*tile, offsetInTile(hit.cell));
  auto id = static_cast<std::uint32_t>(surfels_.size());
  if (free_.empty()) {
    surfels_.push_back(surfel);
  } else {
    id = free_.back();
    free_.pop_back();
    surfels_[id] = surfel;
  }
  tile->nearest[offsetInTile(hit.cell)] = id;
  tile->distance2[offsetInTile(hit.cell)] = 0;
  setOwn(hit.cell, true);
  return id;
}

/// Whether a wall is known so close to a cell that the noise of its hits reaches the cell.
bool SurfelField::isAtWall(const Tile& tile, std::size_t offset) const {
  constexpr float kReach2 = 9.0F;  // cells²
  const std::uint32_t nearest = tile.nearest[offset];
  return nearest != kNone && !surfels_[nearest].appeared &&
         static_cast<float>(tile.distance2[offset]) <= kReach2 * kDistanceSteps;
}

/// Makes room for one more surfel. Returns false at the memory limit.
bool SurfelField::hasRoom() {
  if (!free_.empty() || surfels_.size() < surfels_.capacity()) return true;
  constexpr std::size_t kFirst = 64;
  const std::size_t capacity = std::max(kFirst, surfels_.capacity() + surfels_.capacity() / 2);
  if (!budget_->take((capacity - surfels_.capacity()) * sizeof(Surfel))) return false;
  surfels_.reserve(capacity);
  if (surfels_.empty()) surfels_.push_back(zeros());
  return true;
}

/// Adds the hits of one scan to the mean at once. If they were added one after the other, the last
/// hits of the sweep would have more weight, and the map would rotate slightly with every scan.
/// Returns true if the line of the surfel must be updated.
bool SurfelField::addMean(std::uint32_t id) {
  Surfel& surfel = surfels_[id];
  const bool is_new = surfel.count == 0.0F, is_settled = surfel.count >= kMaxCount;
  surfel.count = std::max(std::min(surfel.count + surfel.new_hits, kMaxCount), surfel.new_hits);
  const Eigen::Vector2f shift = surfel.new_sum / surfel.count;
  surfel.mean += shift;
  surfel.on_wall += shift;
  surfel.count = std::min(surfel.count, kMaxCount);
  surfel.new_hits = 0.0F;
  surfel.new_sum.setZero();
  if (is_new) spread(id);
  return !is_settled || shift.norm() > kMinShift * resolution_;
}

void SurfelField::spread(std::uint32_t id) {
  const Cell& cell = surfels_[id].cell;
  constexpr int kCorner = ~(kTileSide - 1);
  for (int y = (cell.y - kReachCells) & kCorner; y <= cell.y + kReachCells; y += kTileSide) {
    for (int x = (cell.x - kReachCells) & kCorner; x <= cell.x + kReachCells; x += kTileSide)
      spreadIn({x, y}, id);
  }
}

/// Attaches to a surfel the cells of its disk that lie in the tile at `corner`.
void SurfelField::spreadIn(Cell corner, std::uint32_t id) {
  const Cell cell = surfels_[id].cell;
  const Eigen::Vector2f mean = meanInCell(surfels_[id]).array() - 0.5F;
  Tile* tile = nullptr;
  const int last = std::min(cell.y + kReachCells, corner.y + kTileSide - 1);
  for (int y = std::max(cell.y - kReachCells, corner.y); y <= last; ++y) {
    const int half = diskHalfWidth(y - cell.y);
    const int begin = std::max(cell.x - half, corner.x);
    const int end = std::min(cell.x + half + 1, corner.x + kTileSide);
    if (begin >= end) continue;
    if (tile == nullptr) tile = tiles_.obtain(corner);
    if (tile == nullptr) {
      full_ = true;
      return;
    }
    const int offset = (y - corner.y) * kTileSide + begin - corner.x;
    attachRow(id, static_cast<float>(begin - cell.x) - mean.x(),
              static_cast<float>(y - cell.y) - mean.y(), kDistanceSteps,
              {tile->distance2.data() + offset, tile->nearest.data() + offset, end - begin});
  }
}

void SurfelField::remove(const Cell& cell) {
  const std::uint32_t id = idAt(cell);
  if (id == kNone) return;
  setOwn(cell, false);
  detach(id);
  candidates_.clear();
  if (detached_.empty()) return free_.push_back(id);
  Cell low = detached_.front(), high = low;
  for (const Cell& other_cell : detached_) {
    low = {std::min(low.x, other_cell.x), std::min(low.y, other_cell.y)};
    high = {std::max(high.x, other_cell.x), std::max(high.y, other_cell.y)};
  }
  forEachOwn(cell, 2 * kReachCells, [&](std::uint32_t other) {
    const Surfel& surfel = surfels_[other];
    if (surfel.cell.x < low.x - kReachCells || surfel.cell.x > high.x + kReachCells ||
        surfel.cell.y < low.y - kReachCells || surfel.cell.y > high.y + kReachCells) {
      return;
    }
    candidates_.push_back({surfel.mean * inverse_resolution_, surfel.cell, other});
  });
  for (const Cell& other_cell : detached_) attachToNearest(other_cell);
  free_.push_back(id);
}

/// Collects the cells whose nearest surfel is `id`, and removes the reference.
void SurfelField::detach(std::uint32_t id) {
  detached_.clear();
  const Cell cell = surfels_[id].cell;
  for (int dy = -kReachCells; dy <= kReachCells; ++dy) {
    const int y = cell.y + dy, half = diskHalfWidth(dy);
    for (int x = cell.x - half; x <= cell.x + half;) {
      const int end = std::min(cell.x + half, x | (kTileSide - 1)) + 1;
      Tile* tile = tiles_.find({x, y});
      for (std::size_t offset = offsetInTile({x, y}); x < end; ++x, ++offset) {
        if (tile == nullptr || tile->nearest[offset] != id) continue;
        tile->nearest[offset] = kNone;
        tile->distance2[offset] = kFar;
        detached_.push_back({x, y});
      }
    }
  }
}

/// Finds the nearest candidate for a cell.
void SurfelField::attachToNearest(const Cell& cell) {
  const float x = static_cast<float>(cell.x) + 0.5F, y = static_cast<float>(cell.y) + 0.5F;
  float best2 = (kReachCells + 1) * (kReachCells + 1);
  std::uint32_t best = kNone;
  for (const Candidate& candidate : candidates_) {
    // Only within the disk that `spread` fills, because `detach` searches only there.
    const int dx = candidate.cell.x - cell.x, dy = candidate.cell.y - cell.y;
    if (dx * dx + dy * dy > kReachCells * kReachCells) continue;
    const float ex = candidate.mean.x() - x, ey = candidate.mean.y() - y;
    if (ex * ex + ey * ey >= best2) continue;
    best2 = ex * ex + ey * ey;
    best = candidate.id;
  }
  if (best == kNone) return;
  Tile* tile = tiles_.find(cell);
  tile->nearest[offsetInTile(cell)] = best;
  tile->distance2[offsetInTile(cell)] = static_cast<std::uint16_t>(best2 * kDistanceSteps + 1.0F);
}

void SurfelField::updateShape(std::uint32_t id) {
  const Cell cell = surfels_[id].cell;
  const Eigen::Vector2f reference = surfels_[id].mean;
  float n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  forEachOwn(cell, kShapeRadius, [&](std::uint32_t other) {
    const Eigen::Vector2f p = surfels_[other].mean - reference;
    n += 1.0F, sx += p.x(), sy += p.y();
    sxx += p.x() * p.x(), sxy += p.x() * p.y(), syy += p.y() * p.y();
  });
  Surfel& surfel = surfels_[id];
  surfel.a11 = surfel.a22 = 1.0F;
  surfel.a12 = 0.0F;
  sx /= n, sy /= n;
  const float cxx = sxx / n - sx * sx, cxy = sxy / n - sx * sy, cyy = syy / n - sy * sy;
  const float half_trace = 0.5F * (cxx + cyy);
  const Eigen::Vector2f axis2(0.5F * (cxx - cyy),
                              cxy);  // (cos, sin) of twice the angle of the long axis, scaled
  const float root = axis2.norm();
  const float large = half_trace + root, small = std::max(half_trace - root, 0.0F);
  if (n >= kMinShapeCells && root > 0.0F && large > kMinElongation * kMinElongation * small) {
    setLine(surfel, axis2 / root);
  } else if (n < kMinShapeCells && surfel.tangent2.squaredNorm() > 0.0F) {
    setLine(surfel, surfel.tangent2.normalized());
  }
}

/// Places the wall at the mean of all hits across it, also those in the cells next to it. Near the
/// border of two rows of cells the hits of one wall lie in both rows, and each mean contains only a
/// part of them.
void SurfelField::align(std::uint32_t id) {
  Surfel& surfel = surfels_[id];
  surfel.on_wall = surfel.mean;
  if (isPoint(surfel)) return;
  const Eigen::Vector2f normal = normalOf(surfel), along(-normal.y(), normal.x());
  float weights = 0.0F, offsets = 0.0F;
  forEachOwn(surfel.cell, kShapeRadius, [&](std::uint32_t other) {
    const Eigen::Vector2f p = surfels_[other].mean - surfel.mean;
    const float nearness = kAlignReach - std::abs(along.dot(p)) * inverse_resolution_;
    const float weight = std::max(nearness, 0.0F) * surfels_[other].count;
    weights += weight;
    offsets += weight * normal.dot(p);
  });
  surfel.on_wall += offsets / weights * normal;
}

}  // namespace kestrel
