// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {

/// The planned state of a vehicle at one time.
struct PathPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in world, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  double yaw = 0.0;  ///< rad, not wrapped
  double yaw_rate = 0.0;
};

/// A flight plan as a function of time. Each leg begins and ends at rest and follows a B-spline or
/// a straight line. It is as fast as the plan's limits of speed, acceleration and yaw rate allow.
/// The vehicle turns on the spot and hovers between the legs.
class PlanPath {
 public:
  /// Throws std::invalid_argument if the plan is invalid.
  PlanPath(const FlightPlan& plan, double yaw_acceleration_rad_s2);

  double duration() const { return knots_.back().time; }
  PathPoint at(double time) const;

 private:
  struct Knot {
    double time;
    Eigen::Vector3d position, velocity;
    double yaw, yaw_rate;
  };
  struct Sample {
    Eigen::Vector3d position;
    double yaw;
    Eigen::Vector3d tangent = Eigen::Vector3d::Zero();
  };

  static std::vector<Sample> resample(const std::vector<Eigen::Vector4d>& points, double& spacing);
  std::vector<Sample> sampleLeg(std::size_t first, std::size_t last, double& spacing) const;
  std::vector<double> speedsAlong(const std::vector<Sample>& samples, double spacing) const;
  bool legEndsAt(std::size_t waypoint) const;
  void fly(std::size_t first, std::size_t last);
  void turnTo(double yaw);
  void hover(double seconds);

  FlightPlan plan_;
  double yaw_acceleration_;
  std::vector<Knot> knots_;
};

}  // namespace kestrel
