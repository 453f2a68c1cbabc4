// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseArray.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>
#include <tf2_msgs/TFMessage.h>

#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// Convert the messages of a simulated flight to ROS messages. `vehicle` has the sensor models.
sensor_msgs::LaserScan toMessage(const LaserScan& scan, const ros::Time& stamp,
                                 const VehicleModel& vehicle);
sensor_msgs::PointCloud2 toMessage(const PointCloud& cloud, const ros::Time& stamp,
                                   const VehicleModel& vehicle);
sensor_msgs::Imu toMessage(const ImuSample& sample, const ros::Time& stamp,
                           const VehicleModel& vehicle);
sensor_msgs::Range toMessage(const HeightSample& sample, const ros::Time& stamp,
                             const VehicleModel& vehicle);
geometry_msgs::PointStamped toMessage(const Barometer& barometer, const ros::Time& stamp,
                                      const VehicleModel& vehicle);
nav_msgs::Odometry toMessage(const TruePose& pose, const ros::Time& stamp,
                             const VehicleModel& vehicle);
geometry_msgs::PoseArray toMessage(const TrueWalkers& walkers, const ros::Time& stamp,
                                   const VehicleModel& vehicle);

/// The mounting of every sensor of the vehicle.
tf2_msgs::TFMessage mountings(const VehicleModel& vehicle, const ros::Time& stamp);

}  // namespace kestrel
