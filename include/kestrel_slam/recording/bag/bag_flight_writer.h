// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// What a bag of a simulated flight holds.
struct FlightBagSummary {
  std::vector<double> scan_stamps;  ///< of the 2D laser; without one, of the lidar
  std::size_t messages = 0;
};

/// Writes everything that `flight` still sends, on board of `vehicle`, as a rosbag:
///
/// | topic | type | frame |
/// |---|---|---|
/// | /scan | sensor_msgs/LaserScan | laser |
/// | /points | sensor_msgs/PointCloud2: x y z intensity ring time, as velodyne_driver has them |
/// velodyne | | /imu/data | sensor_msgs/Imu | imu_link | | /height | sensor_msgs/Range, looks down
/// | range_finder | | /pressure_height | geometry_msgs/PointStamped: z is the height by the
/// barometer | world | | /ground_truth | nav_msgs/Odometry: pose and, in base_link, velocities |
/// world | | /people | geometry_msgs/PoseArray: where somebody walks | world | | /tf_static |
/// base_link to the frame of every sensor, latched | |
///
/// Header stamps are those of the sensors; the bag's times are those of arrival and begin at
/// kFlightStart. The file appears under its name only when it is complete. Throws
/// std::runtime_error that names the file and the reason.
FlightBagSummary writeFlightBag(const std::string& path, FlightSimulator& flight,
                                const VehicleModel& vehicle);

}  // namespace kestrel
