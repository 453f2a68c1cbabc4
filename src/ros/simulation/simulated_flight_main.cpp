// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/simulation/simulated_flight_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "simulated_flight", "simulated_flight",
      "flies a simulated quadrotor and publishes what its laser, IMU and range finder\n"
      "measure, with the clock. The other nodes need use_sim_time.",
      "roslaunch kestrel_slam demo.launch"};
  return runNode<SimulatedFlightNode, SimulatedFlightConfig>(argc, argv, kProgram);
}
