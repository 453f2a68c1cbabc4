// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace kestrel {

/// What a beam does at a surface.
enum class Material {
  kMatt,   ///< returns
  kGlass,  ///< lets the beam through, except where it is hit nearly straight on
  kBlack   ///< swallows the beam: no return
};

/// An axis-aligned or turned box: walls, furniture, doors. Table tops are flat boxes. What is moved
/// during a flight is two boxes, one until then and one from then on.
struct Box {
  Eigen::Vector3d center;
  Eigen::Vector3d size;  ///< along its own axes, m
  double yaw = 0.0;      ///< rad
  Material material = Material::kMatt;
  double from_s = -std::numeric_limits<double>::infinity();  ///< is there from then
  double until_s = std::numeric_limits<double>::infinity();  ///< to then
};

/// A vertical cylinder: a pillar, a pole, a leg.
struct Cylinder {
  Eigen::Vector2d center;
  double radius = 0.1;
  double bottom = 0.0, top = 2.0;  ///< z, m
  Material material = Material::kMatt;
};

/// Somebody who walks along a closed polygon at constant speed: two legs and a trunk.
struct Walker {
  std::vector<Eigen::Vector2d> corners;
  double speed_m_s = 1.0;
  double phase_m = 0.0;  ///< how far along the polygon at time 0
  Eigen::Vector2d at(double time) const;
  /// From `point` to the nearest place of the way, m; infinite without corners.
  double distanceToWay(const Eigen::Vector2d& point) const;
};

/// What a beam meets first.
struct RayHit {
  double distance = 0.0;  ///< m; +inf: nothing
  double cosine = 1.0;    ///< of the angle of incidence, 0 (grazing) to 1 (straight on)
  Material material = Material::kMatt;
};

/// The solid things of a place: an infinite floor (z = 0), optionally a ceiling, and what stands
/// between. Rays are cast quickly (a grid in the plane tells what may be met).
class World {
 public:
  struct Parts {
    std::vector<Box> boxes;
    std::vector<Cylinder> cylinders;
    std::vector<Walker> walkers;
    double ceiling_m = 3.0;  ///< +inf: open sky
  };

  explicit World(Parts parts);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// The first surface that returns or swallows the beam from `origin` along the unit vector
  /// `direction` at `time` (s), up to `max_distance` (m); glass that is passed is not met.
  RayHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
              double max_distance) const;

  const Parts& parts() const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace kestrel
