// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// The content of a bag of a simulated flight.
struct FlightBagSummary {
  std::vector<double> scan_stamps;  ///< of the 2D laser, or of the lidar if there is no laser
  std::size_t messages = 0;
};

/// Writes all remaining messages of `flight` as a rosbag:
///
/// | topic | type | frame |
/// |---|---|---|
/// | /scan | sensor_msgs/LaserScan | laser |
/// | /points | sensor_msgs/PointCloud2 with the fields of velodyne_driver | velodyne |
/// | /imu/data | sensor_msgs/Imu | imu_link |
/// | /height | sensor_msgs/Range, looks down | range_finder |
/// | /pressure_height | geometry_msgs/PointStamped, z: height of the barometer | world |
/// | /ground_truth | nav_msgs/Odometry, twist in base_link | world |
/// | /people | geometry_msgs/PoseArray, positions of walking people | world |
/// | /tf_static | tf2_msgs/TFMessage, base_link to every sensor, latched | |
///
/// Header stamps are the stamps of the sensors. The record times of the bag are the arrival times,
/// which begin at kFlightStart. The file gets its final name only when it is complete. Throws
/// std::runtime_error with the name of the file and the reason.
FlightBagSummary writeFlightBag(const std::string& path, FlightSimulator& flight,
                                const VehicleModel& vehicle);

}  // namespace kestrel
