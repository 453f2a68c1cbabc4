// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/simulation/laser_model.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// A way along a polyline. The speed is linear between the given times.
struct Journey {
  std::vector<Eigen::Vector2d> path;
  std::vector<std::pair<double, double>> speeds;  ///< time (s) and speed (m/s), by rising time

  /// Distance along the path, m.
  double distanceAt(double time) const;
  /// From the first of `speeds` until the end of the path is reached.
  bool existsAt(double time) const;
  Pose2 at(double time) const;
};

/// A quarter of a circle in 8 pieces from `from` to `to`, around the corner where the directions
/// meet.
std::vector<Eigen::Vector2d> roundedCorner(const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& corner,
                                           const Eigen::Vector2d& to);

enum class ActorKind { kVehicle, kCyclist, kPedestrian };
const char* toString(ActorKind kind);

/// A road user.
struct Actor {
  long id = 0;  ///< from 1 on
  ActorKind kind = ActorKind::kVehicle;
  Eigen::Vector3d size;  ///< length, width, height, m
  Journey journey;
};

/// What happens around a lidar.
struct TrafficScene {
  std::string name;
  World::Parts still;  ///< what never moves
  std::vector<Actor> actors;
  LidarModel lidar;
  double lidar_height_m = 1.73;
  Journey ego;            ///< of the vehicle with the lidar; one point: it stands
  double sway_rad = 0.0;  ///< of the vehicle while it drives
  int frames = 200;
};

/// True place of an actor.
struct TrueBox {
  long id = 0;
  ActorKind kind = ActorKind::kVehicle;
  Eigen::Vector3d center, size;
  double yaw = 0.0, speed = 0.0;
  bool moving = false;     ///< it was more than 0.5 m from here within the last 5 s
  std::size_t points = 0;  ///< returns from it
};

/// A sweep with its truth. All points are measured at the stamp, as in clouds that are corrected
/// for the motion of the vehicle.
struct LabeledSweep {
  PointCloud cloud;                         ///< only returns
  std::vector<long> labels;                 ///< of each point: id of the actor; 0: none
  std::vector<Eigen::Vector3f> unanswered;  ///< directions of the beams without return
  Eigen::Isometry3d pose;                   ///< world_T_lidar
  std::vector<TrueBox> boxes;
};

/// Simulates the sweeps of a scene. The result of a frame does not depend on other frames.
class TrafficSimulator {
 public:
  explicit TrafficSimulator(TrafficScene scene);

  const TrafficScene& scene() const { return scene_; }
  LabeledSweep sweep(int frame) const;

 private:
  Eigen::Isometry3d poseAt(double time) const;
  std::vector<TrueBox> boxesAt(double time) const;

  TrafficScene scene_;
  World world_;
};

/// The crossing of [Siew 2018, sec. VI-A]: an HDL-32E stands in the middle of a crossing with a
/// traffic light. Vehicles drive, stop, start and turn; pedestrians cross. 200 frames at 10 Hz.
TrafficScene crossingScene();
/// As [Siew 2018, sec. VI-B, segment 2]: an HDL-64E drives along an urban street with parked cars,
/// vehicles in both directions and pedestrians. 200 frames at 10 Hz.
TrafficScene streetScene();

}  // namespace kestrel
