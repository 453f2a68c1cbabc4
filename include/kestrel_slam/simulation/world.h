// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace kestrel {

/// How a surface reflects a beam.
enum class Material {
  kMatt,   ///< reflects the beam
  kGlass,  ///< reflects only at nearly perpendicular incidence, else transparent
  kBlack   ///< absorbs the beam: no return
};

/// A box with any yaw: walls, furniture, doors, table tops. An object that is moved during a flight
/// is modeled by two boxes: one exists before that time, the other from then on.
struct Box {
  Eigen::Vector3d center;
  Eigen::Vector3d size;  ///< along the axes of the box, m
  double yaw = 0.0;      ///< rad
  Material material = Material::kMatt;
  double from_s = -std::numeric_limits<double>::infinity();  ///< exists from this time, s
  double until_s = std::numeric_limits<double>::infinity();  ///< until this time, s
};

/// A vertical cylinder: a pillar, a pole, a leg.
struct Cylinder {
  Eigen::Vector2d center;
  double radius = 0.1;
  double bottom = 0.0, top = 2.0;  ///< z, m
  Material material = Material::kMatt;
};

/// A person who wants to walk along a closed polygon at constant speed, and does if nobody is in
/// the way. Modeled by two legs and a trunk.
struct Walker {
  std::vector<Eigen::Vector2d> corners;
  double speed_m_s = 1.0;
  double phase_m = 0.0;  ///< distance along the polygon at time 0
  /// Position in world, m, at `time`, s, if it is alone. With others: World::walkerAt().
  Eigen::Vector2d at(double time) const;
  /// Distance from `point` to the polygon, m; infinite without corners.
  double distanceToPath(const Eigen::Vector2d& point) const;
};

/// The middles of two people are never closer than this, m.
constexpr double kBodyDistance = 0.5;
/// How far a person steps aside from its path to let others pass, at most, m. 0 if all other paths
/// are so far away that it never meets anybody.
double mostAside(const std::vector<Walker>& walkers, std::size_t person);

/// The first surface that a beam hits.
struct RayHit {
  double distance = 0.0;  ///< m; +inf: no hit
  double cosine = 1.0;    ///< of the angle of incidence, from 0 (grazing) to 1 (perpendicular)
  Material material = Material::kMatt;
};

/// The solid objects of a place: an infinite floor at z = 0, optionally a ceiling, and boxes,
/// cylinders and walking people, who keep a distance from each other. A grid in the plane makes ray
/// casting fast.
class World {
 public:
  struct Parts {
    std::vector<Box> boxes;
    std::vector<Cylinder> cylinders;
    std::vector<Walker> walkers;
    double ceiling_m = 3.0;  ///< +inf: open sky
  };

  /// Throws std::invalid_argument if a part is not finite, has no valid size or no duration.
  explicit World(Parts parts);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// Casts a beam from `origin` along the unit vector `direction` at `time` (s). Returns the first
  /// surface within `max_distance` (m) that reflects or absorbs it. Glass that the beam passes is
  /// ignored.
  RayHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
              double max_distance) const;

  /// Position of a person in world, m, at `time`, s: what the beams hit. Those who can meet others
  /// stand before time 0 and after one hour.
  Eigen::Vector2d walkerAt(std::size_t person, double time) const;

  const Parts& parts() const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace kestrel
