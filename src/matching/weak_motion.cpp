// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/weak_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/symmetric_axes.h"
#include "surfel_lanes.h"

namespace kestrel {
namespace {

/// A match is tested with the beams within this distance of their wall, m.
constexpr double kReachM = 0.1;
/// The effect of a motion is tested by moving the vehicle by this distance, m: far enough that the
/// noise of the walls has no effect.
constexpr double kTestM = 0.2;
/// Larger distances of a beam to its wall count as this, m.
constexpr double kMostDistanceM = 0.3;
/// A hit lies on a line with two other hits of the scan in this distance, if its offset from the
/// line is smaller than this, m, and the bend (sine) too.
constexpr float kLeastArmM = 0.3F, kMostArmM = 8.0F, kMostOffsetM = 0.08F, kMostBend = 0.2F;
/// The errors of neighboring beams are correlated: n beams count as n / kCorrelatedBeams.
constexpr double kCorrelatedBeams = 4.0;
/// Least noise of a distance: that of the map, m.
constexpr double kLeastNoiseM = 0.01;
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
                               const Pose2& map_T_base, Beams which, double reach_m = kReachM) {
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
      if (which == Beams::kCertain && surfel.appeared) continue;
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

/// Squared distance of a beam to the surface after the vehicle moved, m². Nothing in unknown space,
/// and where something appeared.
std::optional<double> distance2(const Submap& map, const Pose2& pose, const Beam& beam,
                                const WeakMotion& motion, double moved_m, Beams which) {
  const Eigen::Vector2d velocity = motion.direction + motion.turn_rad_m * beam.turned();
  const Eigen::Vector2d end = pose.translation() + beam.arm + moved_m * velocity;
  const Eigen::Vector2f at = end.cast<float>();
  const Surfel* wall = map.surface().nearest(at);
  if (wall == nullptr) {
    if (which == Beams::kCertain && !map.grid().isKnownOrPresumed(map.grid().cellAt(at)))
      return std::nullopt;
    return kMostDistanceM * kMostDistanceM;
  }
  if (which == Beams::kCertain && wall->appeared) return std::nullopt;
  const Eigen::Vector2d offset = end - wall->mean.cast<double>();
  double distance = 0.0;
  if (!isPoint(*wall)) {
    distance = normalOf({wall->a11, wall->a12, wall->a22}, offset).dot(offset);
  } else {
    distance = beam.isPoint() ? offset.norm() : beam.normal.dot(offset);
  }
  return std::min(distance * distance, kMostDistanceM * kMostDistanceM);
}

/// A parabola through the sums of the squared distances at three places along a motion.
struct Parabola {
  double curvature = 0.0;  ///< half the second derivative, as a number of beams
  double certain = 0.0;    ///< the same, less one standard deviation
  double minimum = 0.0;    ///< its place, m
  double variance = 0.0;   ///< of the place, m²
};

Parabola parabolaOf(const Submap& map, const Pose2& pose, const std::vector<Beam>& beams,
                    const WeakMotion& motion, double step_m, Beams which) {
  double bend = 0.0, bend2 = 0.0, slope = 0.0, slope2 = 0.0;
  for (const Beam& beam : beams) {
    const auto before = distance2(map, pose, beam, motion, -step_m, which);
    const auto middle = distance2(map, pose, beam, motion, 0.0, which);
    const auto after = distance2(map, pose, beam, motion, step_m, which);
    if (!before || !middle || !after) continue;
    const double b = (*before + *after - 2.0 * *middle) / (2.0 * step_m * step_m);
    const double t = (*before - *after) / (4.0 * step_m);
    bend += b, bend2 += b * b, slope += t, slope2 += t * t;
  }
  Parabola result;
  result.curvature = std::max(bend, 0.0);
  result.certain = std::max(bend - std::sqrt(bend2), 0.0);
  if (bend <= 0.0) return result;
  result.minimum = slope / bend;
  const double mean = beams.empty() ? 0.0 : slope / static_cast<double>(beams.size());
  result.variance = kCorrelatedBeams * (slope2 - slope * mean) / (bend * bend);
  return result;
}

}  // namespace

Pose2 WeakMotion::moved(const Pose2& pose, double distance_m) const {
  const Eigen::Vector2d place = pose.translation() + distance_m * direction;
  return {place.x(), place.y(), pose.yaw + distance_m * turn_rad_m};
}

WeakMotion weakMotion(const Submap& map, const Points& points, const Pose2& map_T_base,
                      Beams which) {
  WeakMotion result;
  const std::vector<Beam> beams = fittingBeams(map.surface(), points, map_T_base, which);
  if (beams.empty()) return result;
  const Eigen::Matrix3d covariance = informationOf(beams).inverse();
  const SymmetricAxes<2> axes = symmetricAxes(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  result.direction = axes.eigenvectors.col(1);
  result.turn_rad_m = covariance.block<1, 2>(2, 0).dot(result.direction) / axes.eigenvalues(1);
  const Parabola test = parabolaOf(map, map_T_base, beams, result, kTestM, which);
  result.constraint = test.curvature / static_cast<double>(beams.size());
  return result;
}

AlongFit fitAlong(const Submap& map, const Points& points, const Pose2& start,
                  const WeakMotion& motion, double limit_m, Beams which) {
  constexpr std::array<double, 3> kSteps = {kTestM, 0.5 * kTestM, 0.5 * kTestM};
  AlongFit result;
  for (const double step : kSteps) {
    const Pose2 pose = motion.moved(start, result.distance_m);
    const std::vector<Beam> beams =
        fittingBeams(map.surface(), points, pose, which, kMostDistanceM);
    const Parabola parabola = parabolaOf(map, pose, beams, motion, step, which);
    if (parabola.certain < 1.0) return {};
    result.variance_m2 = std::max(
        parabola.variance, kCorrelatedBeams * kLeastNoiseM * kLeastNoiseM / parabola.certain);
    const double moved = std::clamp(parabola.minimum, -step, step);
    result.distance_m = std::clamp(result.distance_m + moved, -limit_m, limit_m);
  }
  return result;
}

double evidenceAgainst(const Submap& map, const Points& points, const Pose2& map_T_base,
                       const WeakMotion& motion, double distance_m) {
  constexpr Beams which = Beams::kCertain;
  double sum = 0.0, squares = 0.0;
  for (const Beam& beam : fittingBeams(map.surface(), points, map_T_base, which, kMostDistanceM)) {
    const auto here = distance2(map, map_T_base, beam, motion, 0.0, which);
    const auto there = distance2(map, map_T_base, beam, motion, distance_m, which);
    if (!here || !there) continue;
    const double worse = *there - *here;
    sum += worse;
    squares += worse * worse;
  }
  return squares > 0.0 ? sum / std::sqrt(kCorrelatedBeams * squares) : 0.0;
}

}  // namespace kestrel
