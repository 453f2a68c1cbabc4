// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/wall_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {
namespace {

constexpr double kCellM = 0.1;
/// Both vehicles must be sure: several hits, and several beams that passed.
constexpr double kOccupied = 0.9, kFree = 0.25;
/// A wall that the other map has so near, across its direction, is the same one: maps have errors.
/// Along the wall they do not matter, and what stands beside a part of it does not explain the
/// rest.
constexpr double kSameWallM = 0.3;
constexpr std::int64_t kNearCells = 3;  // the same
/// The cells of a wall are within this width, without larger gaps.
constexpr double kWidthM = 0.2, kGapM = 0.35;
constexpr int kDirections = 60;
constexpr std::size_t kMostPoints = 20'000;
/// What stands so near to a wall may be furniture that only one vehicle saw, at its height: the
/// other one saw the wall. It may be longer by this than what stands free.
constexpr double kFurnitureM = 0.8, kLongerM = 1.0;
/// What is compared: up to this way from an agreeing keyframe, and up to this range.
constexpr double kWayM = 5.0;
constexpr float kReachM = 10.0F;

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

/// The scan up to a distance at which errors of the yaw do not move a wall far.
PlanarScan nearPart(PlanarScan scan) {
  for (PlanarRay& ray : scan.rays) {
    const Eigen::Vector2f along = ray.end - ray.origin;
    const float length = along.norm();
    if (length <= kReachM) continue;
    ray.end = ray.origin + along * (kReachM / length);
    ray.hit = false;
  }
  return scan;
}

OccupancyGrid gridOf(const JointMap& joint, const std::vector<PoseVertex>& poses,
                     const std::vector<bool>& used, std::size_t part) {
  OccupancyGridConfig config;
  config.resolution_m = kCellM;
  OccupancyGrid grid(config);
  for (std::size_t i = joint.parts()[part].first; i < joint.parts()[part].last; ++i) {
    if (used[i]) grid.insert(nearPart(joint.keyframes()[i].keyframe->planarScan()), poses[i].pose);
  }
  return grid;
}

/// Whether a cell of a wall is free in the other map.
bool contradicts(const OccupancyGrid& walls, const OccupancyGrid& other, const Cell& cell) {
  return walls.probability(cell) >= kOccupied && other.probability(cell) <= kFree;
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

/// The occupied cells of `walls` that are free in `other`, and those beside them that are occupied
/// in both.
std::vector<Eigen::Vector2d> comparedCells(const OccupancyGrid& walls, const OccupancyGrid& other) {
  std::vector<Eigen::Vector2d> points;
  const MapSnapshot map = walls.snapshot();
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      const Eigen::Vector2d point(map.origin_x + (column + 0.5) * map.resolution_m,
                                  map.origin_y + (row + 0.5) * map.resolution_m);
      const Cell cell = walls.cellAt(point.cast<float>());
      if (contradicts(walls, other, cell) ||
          (other.isOccupied(cell) && isBesideContradiction(walls, other, cell)))
        points.push_back(point);
    }
  }
  return points;
}

/// A cell of a wall in one direction, and whether a wall of the other map explains it.
struct WallCell {
  Eigen::Vector2d at;
  bool explained;
};

/// The longest run of cells in one direction. A cell that is explained ends it: the other map may
/// show a wall only every few cells, where it was seen from far away.
double longestRun(const std::vector<WallCell>& cells, const Eigen::Vector2d& direction,
                  double offset) {
  std::vector<std::tuple<std::int64_t, double, bool>> places;  // line, position on it, explained
  for (const WallCell& cell : cells) {
    const double across = direction.x() * cell.at.y() - direction.y() * cell.at.x();
    places.emplace_back(static_cast<std::int64_t>(std::floor((across + offset) / kWidthM)),
                        direction.dot(cell.at), cell.explained);
  }
  std::sort(places.begin(), places.end());
  double longest = 0.0, begin = 0.0, last = 0.0;
  bool runs = false;
  std::int64_t last_line = 0;
  for (const auto& [line, along, explained] : places) {
    if (!runs || line != last_line || along - last > kGapM) begin = along;
    runs = !explained;
    last_line = line;
    last = along;
    if (runs) longest = std::max(longest, along - begin + kCellM);
  }
  return longest;
}

/// Which of the points have a wall of `other` so near, across a direction.
std::vector<WallCell> comparedWith(const OccupancyGrid& other,
                                   const std::vector<Eigen::Vector2d>& points,
                                   const Eigen::Vector2d& across, double distance_m) {
  std::vector<WallCell> result;
  for (const Eigen::Vector2d& point : points) {
    bool explained = false;
    for (double at = -distance_m; at <= distance_m && !explained; at += 0.5 * kCellM)
      explained = other.isOccupied(other.cellAt((point + at * across).cast<float>()));
    result.push_back({point, explained});
  }
  return result;
}

/// The longest wall in `walls` that is free in `other`.
double longestWall(const OccupancyGrid& walls, const OccupancyGrid& other) {
  std::vector<Eigen::Vector2d> points = comparedCells(walls, other);
  if (points.size() > kMostPoints) points.resize(kMostPoints);
  double longest = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = kPi * i / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d across(-direction.y(), direction.x());
    const std::vector<WallCell> near = comparedWith(other, points, across, kSameWallM);
    const std::vector<WallCell> open = comparedWith(other, points, across, kFurnitureM);
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
  const OccupancyGrid first = gridOf(joint, poses, used, a);
  const OccupancyGrid second = gridOf(joint, poses, used, b);
  return std::max(longestWall(first, second), longestWall(second, first));
}

}  // namespace kestrel
