// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>
#include <tf2_ros/transform_broadcaster.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/PlanarScan.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "node_watcher.h"
#include "tilting_flight.h"

namespace kestrel {

/// Simulates the rest of the robot for a scan projector: publishes the sensor data of a flight, and
/// subscribes to all outputs of the node. Frames in a namespace `ns`: <ns>_base, <ns>_laser,
/// <ns>_imu.
class ProjectorClient : public NodeWatcher {
 public:
  explicit ProjectorClient(const std::string& ns);

  /// Waits until all topics are connected to the projector.
  bool connect(bool with_imu = true);
  /// The same with these publishers of scans and clouds.
  bool connect(const std::vector<ros::Publisher>& lasers, bool with_imu);

  std::string frame(const std::string& name) const { return ns_ + "_" + name; }

  /// Publishes the mounting of a sensor: <ns>_base -> <ns>_`name`.
  void mount(const std::string& name, const Eigen::Isometry3d& base_T_sensor);

  /// Publishes IMU messages at 200 Hz, from the last one up to `time` (s).
  void flyImu(double time);

  /// Returns the next scan of the laser (40 Hz) without publishing it.
  sensor_msgs::LaserScan nextScan();

  /// Publishes a scan and waits for its planar scan.
  std::optional<PlanarScan> project(const sensor_msgs::LaserScan& scan,
                                    double timeout_s = kPatience);

  /// Publishes the next scan and the IMU data up to its end, and expects correct end points.
  void flyOn();

  /// Expects that every hit agrees with the end point of a beam to 1 mm.
  void expectRight(const std::optional<PlanarScan>& scan, double time,
                   const Eigen::Isometry3d& base_T_laser) const;

  /// Advances the time of the flight without any message.
  void skip(double seconds) { time += seconds; }

  ros::NodeHandle nh;
  ros::Publisher scan_publisher, imu_publisher, cloud_publisher, height_publisher;

  TiltingFlight flight;
  Eigen::Isometry3d base_T_laser = mounting(0.1, -0.05, 0.08, 0.05, -0.03, 0.3);
  Eigen::Quaterniond base_R_imu = Eigen::Quaterniond::Identity();
  double time = 1000.1;      ///< of the next scan, s
  double imu_time = 1000.0;  ///< of the next IMU message, s

  std::map<ros::Time, kestrel_slam::PlanarScanConstPtr> planar_scans;  ///< by stamp
  std::vector<sensor_msgs::LaserScan> views;
  std::vector<sensor_msgs::Range> heights;  ///< measured with the mirror

 private:
  std::string ns_;
  ros::Publisher mounting_publisher_;
  tf2_msgs::TFMessage mountings_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace kestrel
