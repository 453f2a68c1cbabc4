// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/wall_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {
namespace {

constexpr double kCellM = 0.1;
/// Both vehicles must be sure: several hits, and several beams that passed.
constexpr double kOccupied = 0.9, kFree = 0.25;
/// A wall that the other map has so near is the same one: maps have errors.
constexpr std::int64_t kNearCells = 3;
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

/// Whether the cell and its surroundings are free.
bool isFree(const OccupancyGrid& grid, const Cell& cell) {
  if (grid.probability(cell) > kFree) return false;
  for (std::int64_t y = cell.y - kNearCells; y <= cell.y + kNearCells; ++y) {
    for (std::int64_t x = cell.x - kNearCells; x <= cell.x + kNearCells; ++x) {
      const Cell near{static_cast<decltype(Cell::x)>(x), static_cast<decltype(Cell::y)>(y)};
      if (grid.isOccupied(near)) return false;
    }
  }
  return true;
}

/// The occupied cells of `walls` that are free in `other`.
std::vector<Eigen::Vector2d> contradictingCells(const OccupancyGrid& walls,
                                                const OccupancyGrid& other) {
  std::vector<Eigen::Vector2d> points;
  const MapSnapshot map = walls.snapshot();
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      const Eigen::Vector2d point(map.origin_x + (column + 0.5) * map.resolution_m,
                                  map.origin_y + (row + 0.5) * map.resolution_m);
      const Cell cell = walls.cellAt(point.cast<float>());
      if (walls.probability(cell) >= kOccupied && isFree(other, cell)) points.push_back(point);
    }
  }
  return points;
}

/// The longest run of points in one direction.
double longestRun(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& direction,
                  double offset) {
  std::vector<std::pair<std::int64_t, double>> places;  // line and position on it
  for (const Eigen::Vector2d& point : points) {
    const double across = direction.x() * point.y() - direction.y() * point.x();
    places.emplace_back(static_cast<std::int64_t>(std::floor((across + offset) / kWidthM)),
                        direction.dot(point));
  }
  std::sort(places.begin(), places.end());
  double longest = 0.0, begin = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool goes_on = i > 0 && places[i].first == places[i - 1].first &&
                         places[i].second - places[i - 1].second <= kGapM;
    if (!goes_on) begin = places[i].second;
    longest = std::max(longest, places[i].second - begin + kCellM);
  }
  return longest;
}

/// The points behind or in front of which `other` has no wall.
std::vector<Eigen::Vector2d> awayFromWalls(const std::vector<Eigen::Vector2d>& points,
                                           const Eigen::Vector2d& across,
                                           const OccupancyGrid& other) {
  std::vector<Eigen::Vector2d> result;
  for (const Eigen::Vector2d& point : points) {
    bool at_wall = false;
    for (double at = -kFurnitureM; at <= kFurnitureM && !at_wall; at += 0.5 * kCellM)
      at_wall = other.isOccupied(other.cellAt((point + at * across).cast<float>()));
    if (!at_wall) result.push_back(point);
  }
  return result;
}

/// The longest wall in `walls` that is free in `other`.
double longestWall(const OccupancyGrid& walls, const OccupancyGrid& other) {
  std::vector<Eigen::Vector2d> points = contradictingCells(walls, other);
  if (points.size() > kMostPoints) points.resize(kMostPoints);
  double longest = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = kPi * i / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const std::vector<Eigen::Vector2d> open =
        awayFromWalls(points, {-direction.y(), direction.x()}, other);
    for (const double offset : {0.0, 0.5 * kWidthM})
      longest = std::max({longest, longestRun(open, direction, offset),
                          longestRun(points, direction, offset) - kLongerM});
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
