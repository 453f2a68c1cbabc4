// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

struct SimulatedFlightConfig {
  std::string world = "laboratory";
  std::string sensor = "utm30lx";
  double speed = 1.0;        ///< of the time; 2: twice as fast
  double random_time = 0.0;  ///< s; 0: the flight of the world
  double start_delay = 1.5;  ///< s of wall time, in which the other nodes start
  int seed = 1;
  bool level = false;
  bool raw_imu = false;
};
std::vector<Parameter> parametersOf(SimulatedFlightConfig& config);

/// Flies the simulator live: publishes what a vehicle with laser and IMU publishes, with the topics
/// and frames of writeFlightBag(), and the clock. At the end of the flight the clock goes on.
class SimulatedFlightNode {
 public:
  /// Throws std::invalid_argument if a parameter is invalid.
  SimulatedFlightNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh);

 private:
  void advertise(ros::NodeHandle& nh);
  void tick();
  void publish(const FlightEvent& event);
  void publishClock(double time);

  SimulatedFlightConfig config_;
  VehicleModel vehicle_;
  std::unique_ptr<World> world_;
  std::unique_ptr<Motion> motion_;
  std::unique_ptr<FlightSimulator> flight_;
  FlightEvent next_;
  bool flying_ = false;
  ros::WallTime start_;
  ros::Publisher clock_, mountings_, scan_, points_, imu_, height_, pressure_height_, truth_,
      people_;
  ros::WallTimer timer_;
};

}  // namespace kestrel
