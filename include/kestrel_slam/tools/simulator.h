#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/tools/flight_path.h"

namespace kestrel_slam {

/// A straight piece of wall, seen from both sides, m.
struct Wall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

/// A place to fly in, and the flight through it.
struct SimulatedWorld {
  std::string name;
  std::string description;
  std::vector<Wall> walls;
  std::vector<Eigen::Vector2d> flight_corners;  ///< see FlightPath
  double speed_m_s = 0.5;

  FlightPath flight() const { return FlightPath(flight_corners, speed_m_s); }
};

/// A 2D laser and its errors.
struct LaserModel {
  std::string name;
  std::string description;
  int beams = 0;
  double angle_min = 0.0;        ///< rad
  double angle_increment = 0.0;  ///< rad
  double time_increment = 0.0;   ///< s between beams; 0: the whole sweep at once
  double rate_hz = 10.0;
  double range_min = 0.0;               ///< m
  double range_max = 0.0;               ///< m
  double sigma_m = 0.0;                 ///< standard deviation of a range
  double resolution_m = 0.0;            ///< ranges are multiples of it; 0: not rounded
  double dropout_probability = 0.0;     ///< of a beam to come back as NaN
  Pose2 base_T_laser = Pose2(0, 0, 0);  ///< mounting, level
};

/// One scan and where the base really was at its stamp.
struct SimulatedScan {
  LaserScan scan;
  Pose2 world_T_base;
};

/// Distance from `origin` along the unit vector `direction` to the nearest wall; +inf: none.
double castRay(const std::vector<Wall>& walls, const Eigen::Vector2d& origin,
               const Eigen::Vector2d& direction);

/// What `laser` records on `flight`: every beam is cast from where the laser is at the beam's own
/// time. The same seed gives the same scans; stamps start at kFlightStart.
std::vector<SimulatedScan> simulate(const std::vector<Wall>& walls, const LaserModel& laser,
                                    const FlightPath& flight, std::uint64_t seed);

/// Stamp of the first scan of every simulated flight, s.
constexpr double kFlightStart = 1.4e9;

/// The built-in places and sensors.
const std::vector<SimulatedWorld>& simulatedWorlds();
const std::vector<LaserModel>& laserModels();

/// Finds one by its name. Throws std::invalid_argument that lists the names there are.
const SimulatedWorld& simulatedWorld(const std::string& name);
const LaserModel& laserModel(const std::string& name);

}  // namespace kestrel_slam
