// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/object_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kDegree = kPi / 180.0;
/// The search over the yaw: first coarse steps, then every degree around the best.
constexpr int kTurn = 90, kCoarse = 5;
constexpr std::size_t kPoints = 60;  ///< that decide over the yaw; of more, some are left out
constexpr double kNear = 0.01;  ///< m; a point nearer to a side does not count more [Zhang 2017]

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

struct Axes {
  Eigen::Vector2d along, across;
  explicit Axes(double yaw)
      : along(std::cos(yaw), std::sin(yaw)), across(-std::sin(yaw), std::cos(yaw)) {}
};

struct Extents {
  Extent along, across;
};

Extents extentsOf(const std::vector<Eigen::Vector2d>& points, const Axes& axes) {
  Extents result;
  for (const Eigen::Vector2d& point : points) {
    result.along.add(axes.along.dot(point));
    result.across.add(axes.across.dot(point));
  }
  return result;
}

/// The axes of every step, because sine and cosine cost more than the projection of a few points.
const Axes& axesOf(int step) {
  static const std::vector<Axes> all = [] {
    std::vector<Axes> axes;
    for (int i = -kCoarse; i < kTurn + kCoarse; ++i) axes.emplace_back(i * kDegree);
    return axes;
  }();
  return all[static_cast<std::size_t>(step + kCoarse)];
}

/// Two values each, for which the processor has instructions. Of an odd number of points, the last
/// is there twice.
using Pairs = std::array<Eigen::Array2d, (kPoints + 1) / 2>;

/// Large if the points lie close to the sides of the rectangle.
double closeness(const Pairs& x, const Pairs& y, std::size_t count, const Axes& axes) {
  Pairs along, across;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Eigen::Array2d first(kFar, kFar), last(-kFar, -kFar), left = first, right = last;
  for (std::size_t i = 0; 2 * i < count; ++i) {
    along[i] = axes.along.x() * x[i] + axes.along.y() * y[i];
    across[i] = axes.across.x() * x[i] + axes.across.y() * y[i];
    first = first.min(along[i]);
    last = last.max(along[i]);
    left = left.min(across[i]);
    right = right.max(across[i]);
  }
  first = first.minCoeff();
  last = last.maxCoeff();
  left = left.minCoeff();
  right = right.maxCoeff();
  double sum = 0.0;  // in the order of the points
  for (std::size_t i = 0; 2 * i < count; ++i) {
    const Eigen::Array2d near = 1.0 / (along[i] - first)
                                          .min(last - along[i])
                                          .min((across[i] - left).min(right - across[i]))
                                          .max(kNear);
    sum += near.x();
    if (2 * i + 1 < count) sum += near.y();
  }
  return sum;
}

std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() <= kPoints) return points;
  std::vector<Eigen::Vector2d> some;
  for (std::size_t i = 0; i < kPoints; ++i) some.push_back(points[i * points.size() / kPoints]);
  return some;
}

}  // namespace

bool OrientedBox::contains(const Eigen::Vector2d& point, double margin) const {
  const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw)), offset = point - center;
  const double across = u.x() * offset.y() - u.y() * offset.x();
  return std::abs(u.dot(offset)) <= 0.5 * size.x() + margin &&
         std::abs(across) <= 0.5 * size.y() + margin;
}

OrientedBox boxAlong(const std::vector<Eigen::Vector2d>& points, double yaw) {
  if (points.empty()) return {};
  const Axes axes(yaw);
  const Extents extents = extentsOf(points, axes);
  OrientedBox box;
  box.center = 0.5 * (extents.along.low + extents.along.high) * axes.along +
               0.5 * (extents.across.low + extents.across.high) * axes.across;
  box.size = {extents.along.high - extents.along.low, extents.across.high - extents.across.low};
  if (box.size.x() < box.size.y()) {
    std::swap(box.size.x(), box.size.y());
    yaw += kPi / 2.0;
  }
  box.yaw = kPi / 2.0 - std::fmod(2.5 * kPi - yaw, kPi);
  if (box.yaw <= -kPi / 2.0) box.yaw += kPi;
  return box;
}

OrientedBox fitBox(const std::vector<Eigen::Vector2d>& points) {
  if (points.empty()) return {};
  const std::vector<Eigen::Vector2d> some = thinned(points);
  Pairs x, y;
  for (std::size_t i = 0; i < some.size() + some.size() % 2; ++i) {
    const Eigen::Vector2d& point = some[std::min(i, some.size() - 1)];
    x[i / 2](static_cast<Eigen::Index>(i % 2)) = point.x();
    y[i / 2](static_cast<Eigen::Index>(i % 2)) = point.y();
  }
  int best_step = 0;
  double best = -1.0;
  const auto tryStep = [&](int step) {
    const double value = closeness(x, y, some.size(), axesOf(step));
    if (value <= best) return;
    best = value;
    best_step = step;
  };
  for (int step = 0; step < kTurn; step += kCoarse) tryStep(step);
  const int middle = best_step;
  for (int step = middle - kCoarse + 1; step < middle + kCoarse; ++step) {
    if (step != middle) tryStep(step);
  }
  return boxAlong(points, best_step * kDegree);
}

std::optional<LShape> lShapeOf(const OrientedBox& box, const Eigen::Vector2d& sensor) {
  const Axes axes(box.yaw);
  const Eigen::Vector2d offset = sensor - box.center;
  const Eigen::Vector2d local(axes.along.dot(offset), axes.across.dot(offset));
  const Eigen::Vector2d half = 0.5 * box.size;
  if (std::abs(local.x()) <= half.x() || std::abs(local.y()) <= half.y()) return std::nullopt;
  const double x = std::copysign(half.x(), local.x()), y = std::copysign(half.y(), local.y());
  const auto at = [&](double along, double across) {
    return Eigen::Vector2d(box.center + along * axes.along + across * axes.across);
  };
  return LShape{at(x, y), at(-x, y), at(x, -y)};
}

}  // namespace kestrel
