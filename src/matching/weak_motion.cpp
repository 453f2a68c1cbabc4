// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/weak_motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "surfel_lanes.h"

namespace kestrel {
namespace {

/// Only beams within this distance of their wall are used, m.
constexpr double kReachM = 0.1;
/// A beam constrains a motion clearly if its wall differs by more than 30 degrees from it. Wrong
/// directions of walls are not as large, because a bend of neighboring hits is limited
/// (wall_tangent.cpp).
constexpr double kClear = 0.5;
/// Distance to the part of the wall with which a beam is compared, m: less has hits in common.
constexpr double kLeastStepM = 0.3, kMostStepM = 1.5;
/// A hit lies on a line with two other hits of the scan in this distance, if its offset from the
/// line is smaller than this, m, and the bend (sine) too.
constexpr float kLeastArmM = 0.3F, kMostArmM = 8.0F, kMostOffsetM = 0.08F, kMostBend = 0.2F;
/// Regularizes the normal equations of a scan with few beams.
constexpr double kLeastInformation = 1e-3;

/// A beam that fits: its wall and its point.
struct Beam {
  Eigen::Vector2d normal;  ///< of the wall, toward the vehicle; zero: a single point
  Eigen::Vector2d arm;     ///< from the vehicle to the end of the beam, in the map frame, m
  Eigen::Vector2d wall;    ///< position of the surfel, m
  Eigen::Vector2d offset;  ///< from the surfel to the end of the beam, m

  bool isPoint() const { return normal.isZero(); }
  Eigen::Vector2d turned() const { return {-arm.y(), arm.x()}; }
  double distance() const { return isPoint() ? offset.norm() : normal.dot(offset); }
  /// Change of the distance to the wall for each meter of `motion`, -1 to 1.
  double slope(const WeakMotion& motion) const {
    const Eigen::Vector2d velocity = motion.direction + motion.turn_rad_m * turned();
    return isPoint() ? velocity.norm() : normal.dot(velocity);
  }
};

/// The normal of a line (a surfel or its constraint), toward the vehicle.
Eigen::Vector2d normalOf(const Eigen::Vector3f& line, const Eigen::Vector2d& arm) {
  const auto squared = [](float a) {
    return std::max(0.0, static_cast<double>((a - kAlongWeight) / (1.0F - kAlongWeight)));
  };
  Eigen::Vector2d normal(std::sqrt(squared(line.x())), std::sqrt(squared(line.z())));
  if (line.y() < 0.0F) normal.y() = -normal.y();
  return normal.dot(arm) > 0.0 ? Eigen::Vector2d(-normal) : normal;
}

/// The nearest hit of the scan before (`step` -1) or after (+1) hit `i` that is far enough away.
std::optional<std::size_t> neighbor(const Points& points, std::size_t i, int step) {
  constexpr int kMostBeams = 128;
  for (int k = 1; k <= kMostBeams; k *= 2) {
    const auto j = static_cast<std::ptrdiff_t>(i) + step * k;
    if (j < 0 || j >= static_cast<std::ptrdiff_t>(points.size())) return std::nullopt;
    const auto found = static_cast<std::size_t>(j);
    if ((points[found] - points[i]).norm() >= kLeastArmM) return found;
  }
  return std::nullopt;
}

/// The direction of the line through hit `i` of a scan and the hits `a` and `b`, if they are on
/// one.
std::optional<Eigen::Vector2f> lineThrough(const Points& points, std::size_t i, std::size_t a,
                                           std::size_t b) {
  const Eigen::Vector2f to_a = points[a] - points[i], to_b = points[b] - points[i];
  const Eigen::Vector2f line = points[b] - points[a];
  const float na = to_a.norm(), nb = to_b.norm(), length = line.norm();
  const float cross = std::abs(to_a.x() * to_b.y() - to_a.y() * to_b.x());
  if (std::max(na, nb) > kMostArmM || length < kLeastArmM || cross > kMostBend * na * nb ||
      cross > kMostOffsetM * length)
    return std::nullopt;
  return line / length;
}

/// The direction of the wall at hit `i` in the scan itself. At the end of a wall both other hits
/// are on the same side.
std::optional<Eigen::Vector2f> directionInScan(const Points& points, std::size_t i) {
  const auto before = neighbor(points, i, -1), after = neighbor(points, i, 1);
  if (before && after) {
    if (const auto line = lineThrough(points, i, *before, *after)) return line;
  }
  if (after) {
    if (const auto next = neighbor(points, *after, 1)) {
      if (const auto line = lineThrough(points, i, *after, *next)) return line;
    }
  }
  if (before) {
    if (const auto next = neighbor(points, *before, -1))
      return lineThrough(points, i, *next, *before);
  }
  return std::nullopt;
}

/// Whether the neighboring hits are far away. Then nobody knows what was hit: such hits on a
/// distant wall move together with the vehicle.
bool isAlone(const Points& points, std::size_t i) {
  return (i == 0 || (points[i] - points[i - 1]).norm() > kLeastArmM) &&
         (i + 1 == points.size() || (points[i + 1] - points[i]).norm() > kLeastArmM);
}

/// The beams within `reach_m` of a wall at `map_T_base`, in their order.
std::vector<Beam> fittingBeams(const SurfelField& surface, const Points& points,
                               const Pose2& map_T_base, double reach_m = kReachM) {
  const auto reach2 = static_cast<float>(reach_m * reach_m);
  const Eigen::Rotation2Df rotation(static_cast<float>(map_T_base.yaw));
  std::vector<Beam> result;
  result.reserve(points.size());
  std::size_t i = 0;
  forEachLanes(surface, points, map_T_base, [&](const SurfelLanes& p, std::size_t count) {
    const Lanes distance2 = p.distance2(), trace = p.a11 + p.a22;
    for (std::size_t k = 0; k < count; ++k, ++i) {
      const auto lane = static_cast<Eigen::Index>(k);
      if (trace[lane] <= 0.0F || distance2[lane] > reach2) continue;
      const Surfel& surfel = *p.surfels[k];
      Beam beam;
      beam.arm = {p.rx[lane], p.ry[lane]};
      beam.wall = surfel.mean.cast<double>();
      beam.offset = {p.ex[lane], p.ey[lane]};
      beam.normal.setZero();
      if (!isPoint(surfel)) {
        beam.normal = normalOf({surfel.a11, surfel.a12, surfel.a22}, beam.arm);
      } else if (const auto along = directionInScan(points, i)) {
        const Eigen::Vector2f t = rotation * *along;
        beam.normal = Eigen::Vector2d(-t.y(), t.x());
        if (beam.normal.dot(beam.arm) > 0.0) beam.normal = -beam.normal;
      } else if (isAlone(points, i)) {
        continue;
      }
      result.push_back(beam);
    }
  });
  return result;
}

Eigen::Matrix3d informationOf(const std::vector<Beam>& beams) {
  Eigen::Matrix3d result = kLeastInformation * Eigen::Matrix3d::Identity();
  for (const Beam& beam : beams) {
    const Eigen::Vector2d turned = beam.turned();
    if (!beam.isPoint()) {
      const Eigen::Vector3d rate(beam.normal.x(), beam.normal.y(), beam.normal.dot(turned));
      result += rate * rate.transpose();
      continue;
    }
    Eigen::Matrix<double, 2, 3> rate;
    rate << 1.0, 0.0, turned.x(), 0.0, 1.0, turned.y();
    result += rate.transpose() * rate;
  }
  return result;
}

/// The product of the slopes of beam `i` and of the next part of its wall: the noise of both is
/// independent, so it has no effect on the mean.
double confirmedSlope2(const std::vector<Beam>& beams, const std::vector<double>& slopes,
                       std::size_t i) {
  for (std::size_t j = i + 1; j < beams.size(); ++j) {
    const double distance = (beams[j].wall - beams[i].wall).norm();
    if (distance < kLeastStepM) continue;
    return distance > kMostStepM || std::abs(slopes[j]) > kClear ? 0.0 : slopes[i] * slopes[j];
  }
  return 0.0;
}

}  // namespace

Pose2 WeakMotion::moved(const Pose2& pose, double distance_m) const {
  const Eigen::Vector2d place = pose.translation() + distance_m * direction;
  return {place.x(), place.y(), pose.yaw + distance_m * turn_rad_m};
}

WeakMotion weakMotion(const SurfelField& surface, const Points& points, const Pose2& map_T_base) {
  WeakMotion result;
  const std::vector<Beam> beams = fittingBeams(surface, points, map_T_base);
  if (beams.empty()) return result;
  const Eigen::Matrix3d covariance = informationOf(beams).inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
      Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  result.direction = axes.eigenvectors().col(1);
  result.turn_rad_m = covariance.block<1, 2>(2, 0).dot(result.direction) / axes.eigenvalues()(1);
  std::vector<double> slopes;
  slopes.reserve(beams.size());
  for (const Beam& beam : beams) slopes.push_back(beam.slope(result));
  double sum = 0.0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const bool clear = std::abs(slopes[i]) > kClear;
    sum += clear ? std::min(slopes[i] * slopes[i], 1.0) : confirmedSlope2(beams, slopes, i);
  }
  result.constraint = std::max(sum, 0.0) / static_cast<double>(beams.size());
  return result;
}

AlongFit fitAlong(const SurfelField& surface, const Points& points, const Pose2& start,
                  const WeakMotion& motion, double limit_m) {
  constexpr int kIterations = 5;
  AlongFit result;
  double reach = std::max(limit_m, kReachM);
  for (int i = 0; i < kIterations; ++i, reach = std::max(0.5 * reach, kReachM)) {
    double information = 0.0, gradient = 0.0, squares = 0.0;
    for (const Beam& beam :
         fittingBeams(surface, points, motion.moved(start, result.distance_m), reach)) {
      const double slope = beam.slope(motion);
      if (std::abs(slope) < kClear) continue;
      const Eigen::Vector2d velocity = motion.direction + motion.turn_rad_m * beam.turned();
      information += slope * slope;
      squares += beam.isPoint() ? beam.offset.squaredNorm() : beam.distance() * beam.distance();
      gradient -= beam.isPoint() ? velocity.dot(beam.offset) : slope * beam.distance();
    }
    result.beams = information;
    if (information < 1.0) return result;
    result.variance_m2 = squares / information;
    result.distance_m = std::clamp(result.distance_m + gradient / information, -limit_m, limit_m);
  }
  return result;
}

}  // namespace kestrel
