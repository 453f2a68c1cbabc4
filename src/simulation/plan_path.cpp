// SPDX-License-Identifier: BSD-3-Clause
#include "plan_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

using Waypoint = FlightPlan::Waypoint;

constexpr double kHoverAtEnds = 1.0;  // s
constexpr double kSamePlace = 1e-3;   // m; closer waypoints mean a turn on the spot
constexpr double kSameYaw = 1e-4;     // rad

void validate(const FlightPlan& plan, double yaw_acceleration) {
  if (plan.waypoints.empty())
    throw std::invalid_argument("a flight plan needs at least one waypoint");
  for (const Waypoint& waypoint : plan.waypoints) {
    if (!waypoint.position.allFinite() || !std::isfinite(waypoint.yaw) ||
        !(waypoint.hover_s >= 0.0 && std::isfinite(waypoint.hover_s))) {
      throw std::invalid_argument(
          "the waypoints of a flight plan must be finite, and hover_s must not be negative");
    }
  }
  for (const double limit :
       {plan.speed_m_s, plan.yaw_rate_rad_s, plan.acceleration_m_s2, yaw_acceleration}) {
    if (!(limit > 0.0 && std::isfinite(limit))) {
      throw std::invalid_argument(
          "speed, yaw rate and accelerations of a flight plan must be positive");
    }
  }
}

/// Weights of four neighboring control points of a uniform cubic B-spline at `u` in [0, 1].
Eigen::Vector4d splineWeights(double u) {
  const double u2 = u * u, u3 = u2 * u, v = 1.0 - u;
  return Eigen::Vector4d(v * v * v, 3.0 * u3 - 6.0 * u2 + 4.0, -3.0 * u3 + 3.0 * u2 + 3.0 * u + 1.0,
                         u3) /
         6.0;
}

Eigen::Vector4d withYaw(const Waypoint& waypoint) {
  return (Eigen::Vector4d() << waypoint.position, waypoint.yaw).finished();
}

/// Points of the spline (x, y, z, yaw) in small steps of its parameter. A mirrored control point at
/// both ends makes the spline begin and end exactly at a waypoint.
std::vector<Eigen::Vector4d> splinePoints(const std::vector<Waypoint>& waypoints, std::size_t first,
                                          std::size_t last) {
  constexpr int kPointsPerSegment = 128;
  std::vector<Eigen::Vector4d> control;
  for (std::size_t i = first; i <= last; ++i) control.push_back(withYaw(waypoints[i]));
  const Eigen::Vector4d before = 2.0 * control[0] - control[1];
  const Eigen::Vector4d after = 2.0 * control.back() - control[control.size() - 2];
  control.insert(control.begin(), before);
  control.push_back(after);
  std::vector<Eigen::Vector4d> points = {control[1]};
  for (std::size_t i = 0; i + 3 < control.size(); ++i) {
    for (int k = 1; k <= kPointsPerSegment; ++k) {
      const Eigen::Vector4d w = splineWeights(static_cast<double>(k) / kPointsPerSegment);
      points.push_back(w[0] * control[i] + w[1] * control[i + 1] + w[2] * control[i + 2] +
                       w[3] * control[i + 3]);
    }
  }
  return points;
}

/// The highest speeds at equally spaced points that start and end at rest, stay below `limits` and
/// need at most `acceleration`.
std::vector<double> restToRest(std::vector<double> limits, double acceleration, double spacing) {
  limits.front() = limits.back() = 0.0;
  const double gain = 2.0 * acceleration * spacing;  // largest change of the squared speed
  for (std::size_t i = 1; i < limits.size(); ++i) {
    limits[i] = std::min(limits[i], std::sqrt(limits[i - 1] * limits[i - 1] + gain));
  }
  for (std::size_t i = limits.size() - 1; i > 0; --i) {
    limits[i - 1] = std::min(limits[i - 1], std::sqrt(limits[i] * limits[i] + gain));
  }
  return limits;
}

/// Yaw of the tangent, unwrapped to be close to `previous`.
double yawAlong(const Eigen::Vector3d& tangent, double previous) {
  constexpr double kMinHorizontal = 1e-3;  // of the unit tangent; in a vertical climb the yaw stays
  if (tangent.head<2>().norm() < kMinHorizontal) return previous;
  return previous + normalizeAngle(std::atan2(tangent.y(), tangent.x()) - previous);
}

}  // namespace

PlanPath::PlanPath(const FlightPlan& plan, double yaw_acceleration_rad_s2)
    : plan_(plan), yaw_acceleration_(yaw_acceleration_rad_s2) {
  validate(plan, yaw_acceleration_rad_s2);
  const std::vector<Waypoint>& points = plan_.waypoints;
  knots_.push_back({0.0, points[0].position, Eigen::Vector3d::Zero(), points[0].yaw, 0.0});
  hover(kHoverAtEnds + points[0].hover_s);
  for (std::size_t first = 0, last = 1; last < points.size(); first = last++) {
    while (!legEndsAt(last)) ++last;
    fly(first, last);
    if (!plan_.nose_forward) turnTo(points[last].yaw);
    hover(points[last].hover_s);
  }
  hover(kHoverAtEnds);
}

bool PlanPath::legEndsAt(std::size_t waypoint) const {
  const std::vector<Waypoint>& points = plan_.waypoints;
  if (waypoint + 1 >= points.size() || !plan_.smooth || points[waypoint].hover_s > 0.0) return true;
  const auto same = [&](std::size_t i) {
    return (points[i + 1].position - points[i].position).norm() < kSamePlace;
  };
  return same(waypoint) || same(waypoint - 1);
}

/// Points (x, y, z, yaw) at equal distances along the line through `points`; none if the line has
/// no length.
std::vector<PlanPath::Sample> PlanPath::resample(const std::vector<Eigen::Vector4d>& points,
                                                 double& spacing) {
  constexpr double kSpacing = 0.01;       // m
  constexpr std::size_t kMinSamples = 5;  // even a short leg needs some to accelerate and brake
  std::vector<double> traveled = {0.0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    traveled.push_back(traveled.back() + (points[i] - points[i - 1]).head<3>().norm());
  }
  if (traveled.back() < kSamePlace) return {};
  const std::size_t count =
      std::max(static_cast<std::size_t>(std::ceil(traveled.back() / kSpacing)) + 1, kMinSamples);
  spacing = traveled.back() / static_cast<double>(count - 1);
  std::vector<Sample> samples;
  for (std::size_t i = 0, at = 0; i < count; ++i) {
    const double wanted = std::min(static_cast<double>(i) * spacing, traveled.back());
    while (at + 2 < points.size() && traveled[at + 1] < wanted) ++at;
    const double step = traveled[at + 1] - traveled[at];
    const double share = step > 0.0 ? std::min((wanted - traveled[at]) / step, 1.0) : 1.0;
    const Eigen::Vector4d point = points[at] + share * (points[at + 1] - points[at]);
    samples.push_back({point.head<3>(), point[3]});
  }
  return samples;
}

/// The path from one waypoint to another, with tangent and yaw.
std::vector<PlanPath::Sample> PlanPath::sampleLeg(std::size_t first, std::size_t last,
                                                  double& spacing) const {
  std::vector<Sample> samples = resample(splinePoints(plan_.waypoints, first, last), spacing);
  double yaw = knots_.back().yaw;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, samples.size() - 1);
    samples[i].tangent = (samples[after].position - samples[before].position).normalized();
    yaw = yawAlong(samples[i].tangent, yaw);
    if (plan_.nose_forward) samples[i].yaw = yaw;
  }
  return samples;
}

std::vector<double> PlanPath::speedsAlong(const std::vector<Sample>& samples,
                                          double spacing) const {
  constexpr double kMinSpeed = 0.02;  // m/s, in a corner of radius zero
  std::vector<double> limits;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& before = samples[i > 0 ? i - 1 : 0];
    const Sample& after = samples[std::min(i + 1, samples.size() - 1)];
    const double curvature = (after.tangent - before.tangent).norm() / (2.0 * spacing);
    const double turn = std::abs(after.yaw - before.yaw) / (2.0 * spacing);  // rad/m
    double limit = plan_.speed_m_s;
    if (curvature > 0.0) limit = std::min(limit, std::sqrt(plan_.acceleration_m_s2 / curvature));
    if (turn > 0.0) limit = std::min(limit, plan_.yaw_rate_rad_s / turn);
    limits.push_back(std::max(limit, kMinSpeed));
  }
  return restToRest(std::move(limits), plan_.acceleration_m_s2, spacing);
}

void PlanPath::fly(std::size_t first, std::size_t last) {
  double spacing = 0.0;
  const std::vector<Sample> samples = sampleLeg(first, last, spacing);
  if (samples.empty()) return;
  turnTo(samples.front().yaw);
  const std::vector<double> speeds = speedsAlong(samples, spacing);
  double time = knots_.back().time;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    time += 2.0 * spacing / (speeds[i - 1] + speeds[i]);
    const double yaw_after = samples[std::min(i + 1, samples.size() - 1)].yaw;
    const double turn = (yaw_after - samples[i - 1].yaw) / (2.0 * spacing);
    knots_.push_back({time, samples[i].position, speeds[i] * samples[i].tangent, samples[i].yaw,
                      speeds[i] * turn});
  }
}

void PlanPath::turnTo(double yaw) {
  constexpr std::size_t kSamples = 101;
  constexpr double kReserve =
      0.8;  // part of the acceleration that is used, so that the vehicle can follow
  const Knot start = knots_.back();
  const double turn = yaw - start.yaw;
  if (std::abs(turn) < kSameYaw) return;
  const double spacing = std::abs(turn) / static_cast<double>(kSamples - 1);
  const std::vector<double> rates = restToRest(std::vector<double>(kSamples, plan_.yaw_rate_rad_s),
                                               kReserve * yaw_acceleration_, spacing);
  double time = start.time;
  for (std::size_t i = 1; i < kSamples; ++i) {
    time += 2.0 * spacing / (rates[i - 1] + rates[i]);
    const double share = static_cast<double>(i) / static_cast<double>(kSamples - 1);
    knots_.push_back({time, start.position, Eigen::Vector3d::Zero(), start.yaw + share * turn,
                      std::copysign(rates[i], turn)});
  }
}

void PlanPath::hover(double seconds) {
  if (seconds <= 0.0) return;
  Knot knot = knots_.back();
  knot.time += seconds;
  knots_.push_back(knot);
}

PathPoint PlanPath::at(double time) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), time,
                                      [](double t, const Knot& knot) { return t < knot.time; });
  PathPoint point;
  if (after == knots_.begin() || after == knots_.end()) {
    const Knot& end = after == knots_.begin() ? knots_.front() : knots_.back();
    point.position = end.position;
    point.yaw = end.yaw;
    return point;
  }
  // Cubic Hermite interpolation of the two knots. It is exact for constant acceleration.
  const Knot &from = *(after - 1), &to = *after;
  const double span = to.time - from.time, t = time - from.time, u = t / span;
  const Eigen::Vector3d slope = (to.position - from.position) / span;
  const Eigen::Vector3d quadratic = (3.0 * slope - 2.0 * from.velocity - to.velocity) / span;
  const Eigen::Vector3d cubic = (from.velocity + to.velocity - 2.0 * slope) / (span * span);
  point.position = from.position + t * (from.velocity + t * (quadratic + t * cubic));
  point.velocity = from.velocity + t * (2.0 * quadratic + 3.0 * t * cubic);
  point.acceleration = 2.0 * quadratic + 6.0 * t * cubic;
  point.yaw_rate = from.yaw_rate + u * (to.yaw_rate - from.yaw_rate);
  point.yaw = from.yaw + u * (to.yaw - from.yaw);
  return point;
}

}  // namespace kestrel
