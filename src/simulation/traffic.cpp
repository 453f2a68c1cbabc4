// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/traffic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "solids.h"

namespace kestrel {
namespace {

constexpr double kMovedDistance = 0.5, kMovedWithin = 5.0;  ///< m, s
constexpr double kStep_m = 0.7;                             ///< of a pedestrian

/// Boxes of an actor for ray casting.
struct Body {
  long id = 0;
  Eigen::Vector2d center;
  double radius = 0.0;
  std::vector<BoxSolid> solids;
};

Box boxAt(const Pose2& pose, double forward, double left, double low, double high, double length,
          double width) {
  const Eigen::Vector2d center = pose * Eigen::Vector2d(forward, left);
  return {{center.x(), center.y(), 0.5 * (low + high)},
          {length, width, high - low},
          pose.yaw,
          Material::kMatt};
}

/// A hull above the wheels and a cabin on it.
std::vector<Box> vehicleBoxes(const Actor& actor, const Pose2& pose) {
  const double length = actor.size.x(), width = actor.size.y(), height = actor.size.z();
  const double hood = height > 2.0 ? height : 0.6 * height;
  std::vector<Box> boxes = {boxAt(pose, 0.0, 0.0, 0.2, hood, length, width)};
  if (height > hood) {
    boxes.push_back(boxAt(pose, -0.05 * length, 0.0, hood, height, 0.55 * length, 0.9 * width));
  }
  for (const double x : {-0.32, 0.32}) {
    for (const double y : {-0.42, 0.42}) {
      boxes.push_back(boxAt(pose, x * length, y * width, 0.0, 0.5, 0.6, 0.2));
    }
  }
  return boxes;
}

/// Two legs that swing, and a trunk.
std::vector<Box> pedestrianBoxes(const Actor& actor, const Pose2& pose, double distance) {
  const double width = actor.size.y(), height = actor.size.z(), hip = 0.48 * height;
  const double swing = 0.25 * std::sin(kPi * distance / kStep_m);
  return {boxAt(pose, swing, 0.25 * width, 0.0, hip, 0.15, 0.15),
          boxAt(pose, -swing, -0.25 * width, 0.0, hip, 0.15, 0.15),
          boxAt(pose, 0.0, 0.0, hip, 0.86 * height, 0.26, width),
          boxAt(pose, 0.0, 0.0, 0.86 * height, height, 0.2, 0.18)};
}

/// A bicycle and its rider.
std::vector<Box> cyclistBoxes(const Actor& actor, const Pose2& pose) {
  const double length = actor.size.x(), height = actor.size.z();
  return {boxAt(pose, 0.0, 0.0, 0.0, 0.7, length, 0.1),
          boxAt(pose, -0.1, 0.0, 0.6, height, 0.4, actor.size.y())};
}

Body bodyOf(const Actor& actor, double time) {
  const Pose2 pose = actor.journey.at(time);
  Body body;
  body.id = actor.id;
  body.center = pose.translation();
  body.radius = 0.5 * actor.size.head<2>().norm() + 0.3;
  const std::vector<Box> boxes = actor.kind == ActorKind::kVehicle ? vehicleBoxes(actor, pose)
                                 : actor.kind == ActorKind::kCyclist
                                     ? cyclistBoxes(actor, pose)
                                     : pedestrianBoxes(actor, pose, actor.journey.distanceAt(time));
  for (const Box& box : boxes) body.solids.emplace_back(box);
  return body;
}

/// True if the beam passes the body closely, seen from above.
bool passesNear(const Ray& ray, const Body& body) {
  const Eigen::Vector2d to = body.center - ray.origin.head<2>();
  const Eigen::Vector2d along = ray.direction.head<2>();
  const double across = along.x() * to.y() - along.y() * to.x();
  return to.dot(along) > -body.radius && std::abs(across) <= body.radius;
}

/// The nearest body that the beam hits before `nearest`; 0: none.
long hitBody(const Ray& ray, const std::vector<Body>& bodies, RayHit& nearest) {
  long label = 0;
  for (const Body& body : bodies) {
    if (!passesNear(ray, body)) continue;
    const double before = nearest.distance;
    for (const BoxSolid& solid : body.solids) solid.intersect(ray, nearest);
    if (nearest.distance < before) label = body.id;
  }
  return label;
}

Eigen::Vector3d beamDirection(const LidarModel& lidar, int column, double elevation) {
  const double azimuth = kPi - 2.0 * kPi * column / lidar.columns;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

}  // namespace

const char* toString(ActorKind kind) {
  switch (kind) {
    case ActorKind::kVehicle:
      return "vehicle";
    case ActorKind::kCyclist:
      return "cyclist";
    default:
      return "pedestrian";
  }
}

double Journey::distanceAt(double time) const {
  double distance = 0.0;
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const auto [from, speed] = speeds[i];
    if (time <= from) break;
    const bool is_last = i + 1 == speeds.size();
    const double to = is_last ? time : std::min(time, speeds[i + 1].first);
    const double gain =
        is_last ? 0.0 : (speeds[i + 1].second - speed) / (speeds[i + 1].first - from);
    distance += (to - from) * (speed + 0.5 * gain * (to - from));
  }
  return distance;
}

bool Journey::existsAt(double time) const {
  if (path.size() < 2) return true;
  double length = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return !speeds.empty() && time >= speeds.front().first && distanceAt(time) < length;
}

Pose2 Journey::at(double time) const {
  double left = distanceAt(time);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d step = path[i] - path[i - 1];
    const double length = step.norm();
    if (left > length && i + 1 < path.size()) {
      left -= length;
      continue;
    }
    const Eigen::Vector2d place = path[i - 1] + step * (left / length);
    // On short pieces of a curve, the direction changes along the piece.
    double yaw = std::atan2(step.y(), step.x());
    if (i + 1 < path.size()) {
      const Eigen::Vector2d next = path[i + 1] - path[i];
      const double bend = normalizeAngle(std::atan2(next.y(), next.x()) - yaw);
      const double near = std::max(0.0, 1.0 - (length - left) / std::min(length, 2.0));
      yaw += 0.5 * bend * near;
    }
    if (i >= 2) {
      const Eigen::Vector2d previous = path[i - 1] - path[i - 2];
      const double bend =
          normalizeAngle(std::atan2(step.y(), step.x()) - std::atan2(previous.y(), previous.x()));
      yaw -= 0.5 * bend * std::max(0.0, 1.0 - left / std::min(length, 2.0));
    }
    return {place.x(), place.y(), normalizeAngle(yaw)};
  }
  return path.empty() ? Pose2() : Pose2(path.front().x(), path.front().y(), 0.0);
}

std::vector<Eigen::Vector2d> roundedCorner(const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& corner,
                                           const Eigen::Vector2d& to) {
  constexpr int kPieces = 8;
  const Eigen::Vector2d center = from + to - corner;
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= kPieces; ++i) {
    const double angle = 0.5 * kPi * i / kPieces;
    points.push_back(center + (from - center) * std::cos(angle) + (to - center) * std::sin(angle));
  }
  return points;
}

TrafficSimulator::TrafficSimulator(TrafficScene scene)
    : scene_(std::move(scene)), world_(scene_.still) {}

Eigen::Isometry3d TrafficSimulator::poseAt(double time) const {
  const Pose2 at = scene_.ego.at(time);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << at.x, at.y, scene_.lidar_height_m + scene_.sway_rad * std::sin(5.1 * time);
  pose.linear() =
      (Eigen::AngleAxisd(at.yaw, Eigen::Vector3d::UnitZ()) *
       Eigen::AngleAxisd(scene_.sway_rad * std::sin(2.3 * time), Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(scene_.sway_rad * std::sin(3.7 * time), Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  return pose;
}

std::vector<TrueBox> TrafficSimulator::boxesAt(double time) const {
  std::vector<TrueBox> boxes;
  for (const Actor& actor : scene_.actors) {
    if (!actor.journey.existsAt(time)) continue;
    const Pose2 pose = actor.journey.at(time);
    TrueBox box;
    box.id = actor.id;
    box.kind = actor.kind;
    box.center << pose.x, pose.y, 0.5 * actor.size.z();
    box.size = actor.size;
    box.yaw = pose.yaw;
    const double now = actor.journey.distanceAt(time);
    constexpr double kShort = 0.01;
    box.speed = (now - actor.journey.distanceAt(time - kShort)) / kShort;
    box.moving = now - actor.journey.distanceAt(time - kMovedWithin) > kMovedDistance;
    boxes.push_back(box);
  }
  return boxes;
}

LabeledSweep TrafficSimulator::sweep(int frame) const {
  const double time = frame / scene_.lidar.rate_hz;
  LabeledSweep result;
  result.cloud.stamp = time;
  result.pose = poseAt(time);
  result.boxes = boxesAt(time);
  std::vector<Body> bodies;
  for (const Actor& actor : scene_.actors) {
    if (actor.journey.existsAt(time)) bodies.push_back(bodyOf(actor, time));
  }
  Random random(static_cast<std::uint64_t>(frame) + 1U);
  const LidarModel& lidar = scene_.lidar;
  for (int column = 0; column < lidar.columns; ++column) {
    for (const double elevation : lidar.elevations) {
      const Eigen::Vector3d direction = beamDirection(lidar, column, elevation);
      const Ray ray{result.pose.translation(), result.pose.linear() * direction, time};
      RayHit hit = world_.cast(ray.origin, ray.direction, time, lidar.range_max);
      const long label = hitBody(ray, bodies, hit);
      if (random.uniform() < lidar.errors.dropout_probability) continue;
      if (!(hit.distance <= lidar.range_max)) {
        result.unanswered.emplace_back(direction.cast<float>());
        continue;
      }
      const double range = hit.distance + lidar.errors.sigma_m * random.gaussian();
      if (range < lidar.range_min) continue;
      const Eigen::Vector3f point = (range * direction).cast<float>();
      result.cloud.points.push_back({point.x(), point.y(), point.z(), 0.0F});
      result.labels.push_back(label);
    }
  }
  for (TrueBox& box : result.boxes) {
    box.points =
        static_cast<std::size_t>(std::count(result.labels.begin(), result.labels.end(), box.id));
  }
  return result;
}

}  // namespace kestrel
