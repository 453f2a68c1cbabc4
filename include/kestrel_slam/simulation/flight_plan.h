// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// The planned flight of a quadrotor: a smooth path through waypoints.
struct FlightPlan {
  struct Waypoint {
    Eigen::Vector3d position;  ///< in world, m
    double yaw = 0.0;          ///< rad, not wrapped: a difference of 4 pi is two turns
    double hover_s = 0.0;      ///< how long the vehicle hovers here, s
  };
  std::vector<Waypoint> waypoints;
  double speed_m_s = 0.5;       ///< largest speed along the path
  double yaw_rate_rad_s = 1.0;  ///< largest yaw rate; turns in hover use this rate
  bool nose_forward = false;    ///< yaw follows the path instead of the waypoints
  bool smooth = true;           ///< B-spline that rounds the corners; false: stops at each waypoint
  double acceleration_m_s2 = 0.8;  ///< largest planned one, along the path and in curves
};

/// Limits of a quadrotor, and the wind.
struct QuadrotorConfig {
  double max_tilt_rad = 0.35;            ///< 20 degrees
  double attitude_frequency_rad_s = 12;  ///< second-order response of roll and pitch
  double attitude_damping = 0.7;
  double gust_m_s2 = 0.3;    ///< standard deviation of the acceleration by wind; 0: still air
  double gust_time_s = 0.7;  ///< correlation time of the wind
  double yaw_acceleration_rad_s2 = 4.0;
  bool level = false;  ///< the same path with zero roll and pitch, for comparison
};

/// Simulates a quadrotor that follows `plan`. Thrust acts along the body's z axis, so the vehicle
/// has to tilt in order to accelerate. Roll and pitch follow the controller with a second-order
/// response, and wind disturbs the vehicle. The result is the true motion of the vehicle, which
/// deviates from the plan. It begins and ends with at least a second of hovering at rest. The same
/// seed gives the same motion. Throws std::invalid_argument if the plan or `config` is invalid.
std::unique_ptr<Motion> flyQuadrotor(const FlightPlan& plan, const QuadrotorConfig& config,
                                     std::uint64_t seed);

/// A built-in world and the standard flight through it.
struct Place {
  std::string name;
  std::string description;
  World::Parts parts;
  FlightPlan plan;
  QuadrotorConfig quadrotor;
};

/// The built-in places: laboratory, ring, corridor, hall, cluttered, glass, people, doors, town,
/// large_town, sparse_town and twins.
const std::vector<Place>& places();
/// The built-in place called `name`. Throws std::invalid_argument, which lists the valid names.
const Place& place(const std::string& name);

/// A random flight of about `duration_s` (s) that keeps a safe distance from all obstacles and
/// people in `place`. It begins at the first waypoint of the place's plan. Throws
/// std::invalid_argument if that plan is empty or the duration is not finite.
FlightPlan randomPlan(const Place& place, double duration_s, std::uint64_t seed);

}  // namespace kestrel
