// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/flight_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

using Waypoint = FlightPlan::Waypoint;

constexpr double kClearance = 0.6;               // m, on the straight legs of a random flight
constexpr double kLowest = 0.7, kHighest = 2.2;  // m above the floor

std::vector<Eigen::Vector3d> sphereDirections() {
  constexpr int kAzimuths = 16;
  std::vector<Eigen::Vector3d> directions = {Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ()};
  for (const double elevation : {-kPi / 4.0, 0.0, kPi / 4.0}) {
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2.0 * kPi * i / kAzimuths;
      directions.emplace_back(std::cos(azimuth) * std::cos(elevation),
                              std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
    }
  }
  return directions;
}

/// The space of a place that is free for flying. Glass counts as solid, and so do the paths of
/// people.
class FreeSpace {
 public:
  explicit FreeSpace(World::Parts parts)
      : walkers_(std::move(parts.walkers)), world_(solid(std::move(parts))) {
    for (std::size_t i = 0; i < walkers_.size(); ++i) aside_.push_back(mostAside(walkers_, i));
  }

  bool isFree(const Eigen::Vector3d& point) const {
    for (std::size_t i = 0; i < walkers_.size(); ++i) {
      const double reach = kClearance + kWalkerRadius + aside_[i];
      if (walkers_[i].distanceToPath(point.head<2>()) < reach) return false;
    }
    for (const Eigen::Vector3d& direction : directions_) {
      if (world_.cast(point, direction, 0.0, kClearance).distance < kClearance) return false;
    }
    return true;
  }

  bool isFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
    constexpr double kStep = 0.2;  // m
    const int steps = 1 + static_cast<int>((to - from).norm() / kStep);
    for (int i = 0; i <= steps; ++i) {
      if (!isFree(from + (to - from) * i / steps)) return false;
    }
    return true;
  }

 private:
  static constexpr double kWalkerRadius = 0.4;  // m

  static World solid(World::Parts parts) {
    parts.walkers.clear();
    for (Box& box : parts.boxes) box.material = Material::kMatt;
    for (Cylinder& cylinder : parts.cylinders) cylinder.material = Material::kMatt;
    return World(std::move(parts));
  }

  std::vector<Walker> walkers_;
  std::vector<double> aside_;  ///< of each walker
  World world_;
  std::vector<Eigen::Vector3d> directions_ = sphereDirections();
};

/// A random next waypoint that can be reached along a free straight line; none if none was found.
std::optional<Waypoint> nextWaypoint(const FreeSpace& space, const Waypoint& from, Random& random) {
  constexpr int kTries = 300;
  constexpr double kShortest = 0.8, kLongest = 6.0;  // m
  constexpr double kLargestClimb = 0.3;              // m per horizontal m
  constexpr double kLargestTurn = kPi / 2.0;
  for (int i = 0; i < kTries; ++i) {
    const double azimuth = random.uniform(-kPi, kPi);
    const double distance = random.uniform(kShortest, kLongest);
    Waypoint to;
    to.position = from.position;
    to.position.head<2>() += distance * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
    to.position.z() += distance * random.uniform(-kLargestClimb, kLargestClimb);
    to.position.z() = std::clamp(to.position.z(), kLowest, kHighest);
    to.yaw = from.yaw + random.uniform(-kLargestTurn, kLargestTurn);
    if (space.isFree(from.position, to.position)) return to;
  }
  return std::nullopt;
}

/// Adds the straight line to `to` in short pieces. The spline then stays close to the corners.
void addLine(std::vector<Waypoint>& waypoints, const Waypoint& to) {
  constexpr double kPiece = 0.8;  // m
  const Waypoint from = waypoints.back();
  const int pieces = std::max(1, static_cast<int>((to.position - from.position).norm() / kPiece));
  for (int i = 1; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    Waypoint between;
    between.position = from.position + share * (to.position - from.position);
    between.yaw = from.yaw + share * (to.yaw - from.yaw);
    waypoints.push_back(between);
  }
}

/// If the first waypoint is not free (too close to the floor), adds a climb to the lowest free
/// height above it.
void climbToFreeHeight(std::vector<Waypoint>& waypoints, const FreeSpace& space) {
  constexpr double kStep = 0.1;  // m
  Waypoint above = waypoints.front();
  if (space.isFree(above.position)) return;
  for (above.position.z() = kLowest; above.position.z() <= kHighest; above.position.z() += kStep) {
    if (!space.isFree(above.position)) continue;
    addLine(waypoints, above);
    return;
  }
}

}  // namespace

FlightPlan randomPlan(const Place& place, double duration_s, std::uint64_t seed) {
  constexpr double kSlowest = 0.3, kFastest = 1.0;         // m/s
  constexpr double kHoverProbability = 0.2, kHover = 1.0;  // s
  if (place.plan.waypoints.empty() || !std::isfinite(duration_s)) {
    throw std::invalid_argument(
        "place '" + place.name +
        "': a random flight needs a place with a plan and a finite duration");
  }
  const FreeSpace space(place.parts);
  Random random(seed);
  FlightPlan plan;
  plan.speed_m_s = random.uniform(kSlowest, kFastest);
  plan.waypoints = {place.plan.waypoints.front()};
  plan.waypoints.front().hover_s = 0.0;
  climbToFreeHeight(plan.waypoints, space);
  double planned_s = 0.0;
  while (planned_s < duration_s) {
    const Eigen::Vector3d from = plan.waypoints.back().position;
    const std::optional<Waypoint> next = nextWaypoint(space, plan.waypoints.back(), random);
    if (!next) break;
    addLine(plan.waypoints, *next);
    if (random.uniform() < kHoverProbability) plan.waypoints.back().hover_s = kHover;
    planned_s += plan.waypoints.back().hover_s + (next->position - from).norm() / plan.speed_m_s;
  }
  // If no waypoint can be reached, the vehicle hovers for the remaining time.
  plan.waypoints.back().hover_s += std::max(0.0, duration_s - planned_s);
  return plan;
}

}  // namespace kestrel
