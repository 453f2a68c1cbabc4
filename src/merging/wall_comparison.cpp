// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/wall_comparison.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "compared_map.h"
#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kCellM = kComparedCellM;
constexpr std::int64_t kNearCells = 3;  // kSameWallM
/// The cells of a wall are within this width, without larger gaps.
constexpr double kWidthM = 0.2, kGapM = 0.35;
constexpr int kDirections = 60;
constexpr std::size_t kMostPoints = 20'000;
/// What stands so near to a wall may be furniture that only one vehicle saw, at its height: the
/// other one saw the wall. It may be longer by this than what stands free.
constexpr double kFurnitureM = 0.8, kLongerM = 1.0;
/// What is compared: up to this way from an agreeing keyframe.
constexpr double kWayM = 5.0;

double stepOf(const JointMap& joint, std::size_t i) {
  return joint.poseOf(i - 1).between(joint.poseOf(i)).distance();
}

/// For each keyframe, whether an agreeing one is near on the way of the vehicle.
std::vector<bool> nearAgreeing(const JointMap& joint, const std::vector<Loop>& agreeing) {
  std::vector<double> away(joint.keyframes().size(), std::numeric_limits<double>::infinity());
  for (const Loop& loop : agreeing) away[loop.query] = away[loop.anchor] = 0.0;
  for (const JointMap::Part& part : joint.parts()) {
    for (std::size_t i = part.first + 1; i < part.last; ++i)
      away[i] = std::min(away[i], away[i - 1] + stepOf(joint, i));
    for (std::size_t i = part.last; i-- > part.first + 1;)
      away[i - 1] = std::min(away[i - 1], away[i] + stepOf(joint, i));
  }
  std::vector<bool> near;
  for (const double distance : away) near.push_back(distance <= kWayM);
  return near;
}

/// Whether a cell of a wall is free in the other map.
bool contradicts(const OccupancyGrid& walls, const OccupancyGrid& other, const Cell& cell) {
  return walls.probability(cell) >= kSure.occupied && other.probability(cell) <= kSure.free;
}

bool isBesideContradiction(const OccupancyGrid& walls, const OccupancyGrid& other,
                           const Cell& cell) {
  for (std::int64_t y = cell.y - kNearCells; y <= cell.y + kNearCells; ++y) {
    for (std::int64_t x = cell.x - kNearCells; x <= cell.x + kNearCells; ++x) {
      const Cell near{static_cast<decltype(Cell::x)>(x), static_cast<decltype(Cell::y)>(y)};
      if (contradicts(walls, other, near)) return true;
    }
  }
  return false;
}

template <typename Visit>
void forEachWall(const OccupancyGrid& walls, Visit visit) {
  const MapSnapshot map = walls.snapshot();
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      const Eigen::Vector2d point(map.origin_x + (column + 0.5) * map.resolution_m,
                                  map.origin_y + (row + 0.5) * map.resolution_m);
      visit(point, walls.cellAt(point.cast<float>()));
    }
  }
}

/// The occupied cells of `walls` that are free in `other`, and those beside them that are occupied
/// in both.
std::vector<Eigen::Vector2d> comparedCells(const OccupancyGrid& walls, const OccupancyGrid& other) {
  std::vector<Eigen::Vector2d> points;
  forEachWall(walls, [&](const Eigen::Vector2d& point, const Cell& cell) {
    if (contradicts(walls, other, cell) ||
        (other.isOccupied(cell) && isBesideContradiction(walls, other, cell)))
      points.push_back(point);
  });
  return points;
}

/// The direction of a straight wall; zero if it is not straight.
Eigen::Vector2d directionAt(const OccupancyGrid& walls, const Eigen::Vector2d& point) {
  constexpr std::int64_t kAround = 5;  // cells
  constexpr double kStraight = 4.0;    // ratio of the squared extents
  const Cell center = walls.cellAt(point.cast<float>());
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  double count = 0.0;
  for (std::int64_t y = -kAround; y <= kAround; ++y) {
    for (std::int64_t x = -kAround; x <= kAround; ++x) {
      if (!walls.isOccupied({static_cast<decltype(Cell::x)>(center.x + x),
                             static_cast<decltype(Cell::y)>(center.y + y)}))
        continue;
      const Eigen::Vector2d cell(static_cast<double>(x), static_cast<double>(y));
      sum += cell;
      squares += cell * cell.transpose();
      count += 1.0;
    }
  }
  if (count < 2.0) return Eigen::Vector2d::Zero();
  const Eigen::Matrix2d covariance = squares / count - sum * sum.transpose() / (count * count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const bool is_straight = solver.eigenvalues()[1] > kStraight * solver.eigenvalues()[0];
  return is_straight ? Eigen::Vector2d(solver.eigenvectors().col(1)) : Eigen::Vector2d::Zero();
}

/// A cell of a wall that the other map does not show, or not at all heights.
struct DifferingCell {
  Eigen::Vector2d at;
  HeightVerdict heights = HeightVerdict::kSaysNothing;
};

/// The same in one direction, and whether a wall of the other map explains it.
struct WallCell {
  Eigen::Vector2d at;
  bool by_height, explained;
};

/// The longest run of cells in one direction. A cell that is explained ends it: the other map may
/// show a wall only every few cells, where it was seen from far away. What the heights explain does
/// not end a run, so that a few such cells do not hide a wall, but it adds nothing to its length.
double longestRun(const std::vector<WallCell>& cells, const Eigen::Vector2d& direction,
                  double offset) {
  // line, position on it, explained by a wall, by the height
  std::vector<std::tuple<std::int64_t, double, bool, bool>> places;
  for (const WallCell& cell : cells) {
    const double across = direction.x() * cell.at.y() - direction.y() * cell.at.x();
    places.emplace_back(static_cast<std::int64_t>(std::floor((across + offset) / kWidthM)),
                        direction.dot(cell.at), cell.explained, cell.by_height);
  }
  std::sort(places.begin(), places.end());
  double longest = 0.0, begin = 0.0, by_heights = 0.0, last = 0.0;
  bool runs = false, last_by_height = false;
  std::int64_t last_line = 0;
  for (const auto& [line, along, explained, by_height] : places) {
    if (!runs || line != last_line || along - last > kGapM) {
      begin = along;
      by_heights = by_height ? kCellM : 0.0;
    } else if (by_height && last_by_height) {
      by_heights += along - last;
    }
    runs = !explained;
    last_line = line;
    last = along;
    last_by_height = by_height;
    if (runs) longest = std::max(longest, along - begin + kCellM - by_heights);
  }
  return longest;
}

/// Whether a wall of `other` explains a cell. If the heights contradict, no wall of the other map
/// is at the cell, and one that this vehicle saw through at some heights, as a lintel, is not
/// behind it.
bool explains(const ComparedMap& other, const Cell& near, double distance_m,
              const DifferingCell& cell) {
  if (!other.grid().isOccupied(near)) return false;
  return cell.heights != HeightVerdict::kContradicted ||
         (distance_m > kSameWallM && !other.isPassed(near));
}

/// Whether the other vehicle saw free space on both sides of a wall, farther away than the maps may
/// be wrong. If not, the wall bounds what it saw: its beams passed along the wall, or ended there.
/// Behind the ends of an opening, what stands beside it hides the free space.
bool isCrossed(const OccupancyGrid& other, const Eigen::Vector2d& at,
               const Eigen::Vector2d& across) {
  const Eigen::Vector2d along(across.y(), -across.x());
  const auto isFree = [&](const Eigen::Vector2d& side) {
    for (double step = -kSameWallM; step <= kSameWallM; step += 0.5 * kCellM) {
      const Eigen::Vector2d point = side + step * along;
      if (other.probability(other.cellAt(point.cast<float>())) <= kSure.free) return true;
    }
    return false;
  };
  return isFree(at + kSameWallM * across) && isFree(at - kSameWallM * across);
}

/// Which of the cells have a wall of `other` so near, across a direction, or are not crossed in it.
std::vector<WallCell> comparedWith(const ComparedMap& other,
                                   const std::vector<DifferingCell>& cells,
                                   const Eigen::Vector2d& across, double distance_m) {
  std::vector<WallCell> result;
  for (const DifferingCell& cell : cells) {
    bool explained =
        cell.heights != HeightVerdict::kContradicted && !isCrossed(other.grid(), cell.at, across);
    for (double at = -distance_m; at <= distance_m && !explained; at += 0.5 * kCellM) {
      const Cell near = other.grid().cellAt((cell.at + at * across).cast<float>());
      explained = explains(other, near, std::abs(at), cell);
    }
    result.push_back({cell.at, cell.heights == HeightVerdict::kExplained, explained});
  }
  return result;
}

/// Adds to `points` the cells of walls that the other vehicle saw at some heights only: its map may
/// show the lintel of a door as a wall.
void addOpenCells(const ComparedMap& walls, const ComparedMap& other,
                  std::vector<Eigen::Vector2d>& points) {
  forEachWall(walls.grid(), [&](const Eigen::Vector2d& point, const Cell& cell) {
    if (walls.grid().probability(cell) >= kSure.occupied && other.isPassed(cell) &&
        other.grid().probability(cell) > kSure.free)
      points.push_back(point);
  });
}

std::vector<DifferingCell> differingCells(const ComparedMap& walls, const ComparedMap& other) {
  std::vector<Eigen::Vector2d> points = comparedCells(walls.grid(), other.grid());
  const std::size_t count = points.size();  // further ones count only if the heights contradict
  const bool has_heights = walls.knowsHeights() && other.knowsHeights();
  if (has_heights) addOpenCells(walls, other, points);
  if (points.size() > kMostPoints) points.resize(kMostPoints);
  std::vector<DifferingCell> cells;
  if (!has_heights) {
    for (const Eigen::Vector2d& point : points) cells.push_back({point});
    return cells;
  }
  std::vector<ComparedPoint> wall_points;
  for (const Eigen::Vector2d& point : points)
    wall_points.push_back({point, directionAt(walls.grid(), point)});
  const std::vector<Sightings> here = walls.sightings(wall_points);
  const std::vector<Sightings> there = other.sightings(wall_points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const HeightVerdict verdict = compareHeights(here[i], there[i], kSure);
    if (i < count || verdict == HeightVerdict::kContradicted) cells.push_back({points[i], verdict});
  }
  return cells;
}

/// The longest wall in `walls` that is free in `other`.
double longestWall(const ComparedMap& walls, const ComparedMap& other) {
  const std::vector<DifferingCell> cells = differingCells(walls, other);
  double longest = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = kPi * i / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d across(-direction.y(), direction.x());
    const std::vector<WallCell> near = comparedWith(other, cells, across, kSameWallM);
    const std::vector<WallCell> open = comparedWith(other, cells, across, kFurnitureM);
    for (const double offset : {0.0, 0.5 * kWidthM})
      longest = std::max({longest, longestRun(open, direction, offset),
                          longestRun(near, direction, offset) - kLongerM});
  }
  return longest;
}

}  // namespace

double longestContradictingWall(const JointMap& joint, const std::vector<PoseVertex>& poses,
                                const std::vector<Loop>& agreeing, std::size_t a, std::size_t b) {
  const std::vector<bool> used = nearAgreeing(joint, agreeing);
  const ComparedMap first(joint, poses, used, a), second(joint, poses, used, b);
  return std::max(longestWall(first, second), longestWall(second, first));
}

}  // namespace kestrel
