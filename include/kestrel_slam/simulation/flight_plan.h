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

/// What a quadrotor is asked to do: a smooth path through waypoints.
struct FlightPlan {
  struct Waypoint {
    Eigen::Vector3d position;  ///< in world, m
    double yaw = 0.0;          ///< rad, not wrapped: a difference of 4 pi is two turns
    double hover_s = 0.0;      ///< stays here
  };
  std::vector<Waypoint> waypoints;
  double speed_m_s = 0.5;          ///< along the path
  double yaw_rate_rad_s = 1.0;     ///< largest; in hover, turns are made at this rate
  bool nose_forward = false;       ///< yaw follows the path instead of the waypoints
  bool smooth = true;              ///< B-spline that rounds the corners; false: stops at each point
  double acceleration_m_s2 = 0.8;  ///< largest that is asked for, along the path and in its bends
};

/// How a quadrotor follows its plan.
struct QuadrotorConfig {
  double max_tilt_rad = 0.35;            ///< 20 degrees
  double attitude_frequency_rad_s = 12;  ///< second-order response of roll and pitch
  double attitude_damping = 0.7;
  double gust_m_s2 = 0.3;  ///< standard deviation of the wind's acceleration, 0: still air
  double gust_time_s = 0.7;
  double yaw_acceleration_rad_s2 = 4.0;
  bool level = false;  ///< the very same path without roll and pitch: to compare with
};

/// Flies `plan` with a quadrotor whose tilt follows from its acceleration: thrust along the body's
/// z axis accelerates it, roll and pitch follow the controller with a second-order response, wind
/// pushes. The motion is what such a vehicle really does, sampled finely and interpolated smoothly.
/// It begins and ends with at least a second of hovering at rest. The same seed gives the same
/// motion. Throws std::invalid_argument on a plan that cannot be flown.
std::unique_ptr<Motion> flyQuadrotor(const FlightPlan& plan, const QuadrotorConfig& config,
                                     std::uint64_t seed);

/// A place to fly in, and the flight through it.
struct Place {
  std::string name;
  std::string description;
  World::Parts parts;
  FlightPlan plan;
  QuadrotorConfig quadrotor;
};

/// laboratory, ring, corridor, hall, cluttered, glass, people, doors, town, large_town: the
/// built-in places.
const std::vector<Place>& places();
/// Finds one by its name. Throws std::invalid_argument that lists the names there are.
const Place& place(const std::string& name);

/// A random flight that keeps its distance from everything in `place`.
FlightPlan randomPlan(const Place& place, double duration_s, std::uint64_t seed);

}  // namespace kestrel
