// SPDX-License-Identifier: BSD-3-Clause
#include "solids.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

/// The part of a ray inside a solid, and the cosine of its angle of incidence.
struct Span {
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  double cosine = 1.0;
};

/// Clips `span` to the slab between two parallel planes at -half and +half. False if nothing is
/// left.
bool clipSlab(double origin, double direction, double half, Span& span) {
  if (direction == 0.0) return std::abs(origin) <= half;
  const double inverse = 1.0 / direction;
  const double to_middle = -origin * inverse, through = std::abs(half * inverse);
  if (to_middle - through > span.enter) {
    span.enter = to_middle - through;
    span.cosine = std::abs(direction);
  }
  span.leave = std::min(span.leave, to_middle + through);
  return span.enter <= span.leave;
}

/// Clips `span` to an infinite vertical cylinder around the origin. False if nothing is left.
bool clipCylinder(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction, double radius,
                  Span& span) {
  const double a = direction.squaredNorm();
  const double c = origin.squaredNorm() - radius * radius;
  if (a == 0.0) return c <= 0.0;
  const double b = origin.dot(direction);
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return false;
  const double root = std::sqrt(discriminant);
  if ((-b - root) / a > span.enter) {
    span.enter = (-b - root) / a;
    span.cosine = root / radius;
  }
  span.leave = std::min(span.leave, (-b + root) / a);
  return span.enter <= span.leave;
}

void keepNearest(const Span& span, Material material, RayHit& nearest) {
  // Glass reflects to the laser only at nearly perpendicular incidence.
  static const double kGlassCosine = std::cos(degToRad(5.0));
  if (span.enter >= nearest.distance) return;
  if (material == Material::kGlass && span.cosine < kGlassCosine) return;
  nearest = {span.enter, span.cosine, material};
}

}  // namespace

BoxSolid::BoxSolid(const Box& box)
    : center_(box.center),
      half_(box.size / 2.0),
      cos_(std::cos(box.yaw)),
      sin_(std::sin(box.yaw)),
      material_(box.material),
      from_s_(box.from_s),
      until_s_(box.until_s) {}

void BoxSolid::intersect(const Ray& ray, RayHit& nearest) const {
  if (ray.time < from_s_ || ray.time >= until_s_) return;
  const Eigen::Vector3d from = ray.origin - center_;
  const Eigen::Vector3d& along = ray.direction;
  Span span;
  span.leave = nearest.distance;
  const bool hit = clipSlab(cos_ * from.x() + sin_ * from.y(), cos_ * along.x() + sin_ * along.y(),
                            half_.x(), span) &&
                   clipSlab(cos_ * from.y() - sin_ * from.x(), cos_ * along.y() - sin_ * along.x(),
                            half_.y(), span) &&
                   clipSlab(from.z(), along.z(), half_.z(), span);
  if (hit) keepNearest(span, material_, nearest);
}

Eigen::Vector2d BoxSolid::halfExtent() const {
  const double c = std::abs(cos_), s = std::abs(sin_);
  return {c * half_.x() + s * half_.y(), s * half_.x() + c * half_.y()};
}

bool BoxSolid::overlapsCell(const Eigen::Vector2d& center, double half_cell) const {
  // Separating axis test: two rectangles are disjoint if an axis of one of them separates them.
  const Eigen::Vector2d offset = center - center_.head<2>();
  const Eigen::Vector2d extent = halfExtent();
  const double half_cell_turned = half_cell * (std::abs(cos_) + std::abs(sin_));
  return std::abs(offset.x()) <= extent.x() + half_cell &&
         std::abs(offset.y()) <= extent.y() + half_cell &&
         std::abs(cos_ * offset.x() + sin_ * offset.y()) <= half_.x() + half_cell_turned &&
         std::abs(cos_ * offset.y() - sin_ * offset.x()) <= half_.y() + half_cell_turned;
}

void CylinderSolid::intersect(const Ray& ray, RayHit& nearest) const {
  const double middle = (cylinder_.bottom + cylinder_.top) / 2.0;
  Span span;
  span.leave = nearest.distance;
  const bool hit =
      clipCylinder(ray.origin.head<2>() - cylinder_.center, ray.direction.head<2>(),
                   cylinder_.radius, span) &&
      clipSlab(ray.origin.z() - middle, ray.direction.z(), cylinder_.top - middle, span);
  if (hit) keepNearest(span, cylinder_.material, nearest);
}

bool CylinderSolid::overlapsCell(const Eigen::Vector2d& center, double half_cell) const {
  const Eigen::Vector2d outside =
      ((center - cylinder_.center).cwiseAbs().array() - half_cell).cwiseMax(0.0);
  return outside.squaredNorm() <= cylinder_.radius * cylinder_.radius;
}

void intersectPlane(double z, const Ray& ray, RayHit& nearest) {
  if (ray.direction.z() == 0.0) return;
  const double distance = (z - ray.origin.z()) / ray.direction.z();
  if (distance >= 0.0 && distance < nearest.distance) {
    nearest = {distance, std::abs(ray.direction.z()), Material::kMatt};
  }
}

}  // namespace kestrel
