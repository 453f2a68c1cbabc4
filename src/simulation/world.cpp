// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/world.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "crowd.h"
#include "solid_grid.h"

namespace kestrel {
namespace {

void validate(const World::Parts& parts) {
  for (const Box& box : parts.boxes) {
    if (!box.center.allFinite() || !box.size.allFinite() || !std::isfinite(box.yaw) ||
        !(box.size.array() >= 0.0).all() || !(box.from_s < box.until_s)) {
      throw std::invalid_argument(
          "a box of a world must be finite, must not have a negative size, and from_s must be less "
          "than until_s");
    }
  }
  for (const Cylinder& cylinder : parts.cylinders) {
    if (!cylinder.center.allFinite() || !std::isfinite(cylinder.bottom) ||
        !std::isfinite(cylinder.top) || !(cylinder.top >= cylinder.bottom) ||
        !(std::isfinite(cylinder.radius) && cylinder.radius > 0.0)) {
      throw std::invalid_argument(
          "a cylinder of a world must be finite, with a positive radius and its top above its "
          "bottom");
    }
  }
  for (const Walker& walker : parts.walkers) {
    bool finite = std::isfinite(walker.speed_m_s) && std::isfinite(walker.phase_m);
    for (const Eigen::Vector2d& corner : walker.corners) finite = finite && corner.allFinite();
    if (!finite || walker.corners.empty()) {
      throw std::invalid_argument(
          "a walker of a world needs corners, and all its values must be finite");
    }
  }
  if (!(parts.ceiling_m > 0.0)) {
    throw std::invalid_argument("the ceiling of a world must be above its floor");
  }
}

}  // namespace

struct World::Index {
  explicit Index(Parts all)
      : parts(std::move(all)), grid(parts.boxes, parts.cylinders), crowd(parts) {}

  Parts parts;
  SolidGrid grid;
  Crowd crowd;
};

World::World(Parts parts) {
  validate(parts);
  index_ = std::make_unique<Index>(std::move(parts));
}

World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

RayHit World::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
                   double max_distance) const {
  const Ray ray = {origin, direction, time};
  RayHit nearest;
  nearest.distance = max_distance;
  intersectPlane(0.0, ray, nearest);
  if (std::isfinite(index_->parts.ceiling_m)) intersectPlane(index_->parts.ceiling_m, ray, nearest);
  index_->crowd.intersect(ray, nearest);
  index_->grid.intersect(ray, nearest);
  if (!(nearest.distance < max_distance)) return {std::numeric_limits<double>::infinity()};
  return nearest;
}

Eigen::Vector2d World::walkerAt(std::size_t person, double time) const {
  return index_->crowd.at(person, time).position;
}

const World::Parts& World::parts() const { return index_->parts; }

}  // namespace kestrel
