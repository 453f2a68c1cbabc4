// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/sensor_models.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// An IMU with an attitude filter of its own (Xsens MTi class); figures of its data sheet.
struct ImuModel {
  double rate_hz = 100.0;
  double gyro_noise = 0.0009;          ///< density, rad/s/sqrt(Hz)
  double gyro_bias = 0.003;            ///< standard deviation of the bias at the start, rad/s
  double gyro_bias_walk = 0.00002;     ///< rad/s²/sqrt(Hz)
  double accelerometer_noise = 0.002;  ///< density, m/s²/sqrt(Hz)
  double accelerometer_bias = 0.02;    ///< standard deviation of the bias at the start, m/s²
  double accelerometer_bias_walk = 0.0001;
  double misalignment_rad = 0.002;    ///< standard deviation of the mounting's error, each axis
  double attitude_sigma_rad = 0.005;  ///< slowly varying error of roll and pitch
  double attitude_time_s = 5.0;       ///< its correlation time
  double yaw_sigma_rad = 0.05;        ///< of the magnetometer's yaw
  double latency_s = 0.005;
  bool gives_orientation = true;
};

/// A range finder that looks along the base's negative z axis.
struct RangeFinderModel {
  double rate_hz = 20.0;
  double sigma_m = 0.01;
  double range_min = 0.05, range_max = 6.0;  ///< m
  double latency_s = 0.01;
};

struct BarometerModel {
  double rate_hz = 10.0;
  double sigma_m = 0.1;
  double drift_m_per_sqrt_s = 0.02;
  double latency_s = 0.02;
};

/// Something that covers a part of every laser's view for a time, close to it.
struct BlockedView {
  double from_s = 0.0, until_s = 0.0;       ///< after the start
  double first_rad = -kPi, last_rad = kPi;  ///< beams, in the laser's frame
  double range_m = 0.4;                     ///< what they measure there
};

/// What the vehicle carries, and how its messages come through.
struct VehicleModel {
  std::optional<LaserModel> laser;
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  /// Its sweeps begin half a period after those of `laser`.
  std::optional<LaserModel> second_laser;
  Eigen::Isometry3d base_T_second_laser = Eigen::Isometry3d::Identity();
  std::optional<LidarModel> lidar;
  Eigen::Isometry3d base_T_lidar = Eigen::Isometry3d::Identity();
  std::optional<ImuModel> imu = ImuModel();
  Eigen::Quaterniond base_R_imu = Eigen::Quaterniond::Identity();
  std::optional<RangeFinderModel> range_finder = RangeFinderModel();
  std::optional<BarometerModel> barometer = BarometerModel();
  double truth_rate_hz = 100.0;
  double scan_latency_s = 0.005;  ///< after the last beam of the sweep
  double stamp_jitter_s = 0.0;    ///< standard deviation of the stamps' error
  double loss_probability = 0.0;  ///< of every message of a sensor
  std::vector<BlockedView> blocked_views;
};

/// A small quadrotor with all of the sensors above, and on top the laser or lidar `sensor`. Throws
/// std::invalid_argument that lists the names there are.
VehicleModel quadrotorWith(const std::string& sensor);

/// Where a moving person truly is.
struct TrueWalkers {
  std::vector<Eigen::Vector2d> positions;  ///< in world, in the order of World::Parts::walkers
};

struct TruePose {
  TrueState state;
};

/// One message of the flight. `height` of a HeightSample: range finder; `Barometer` the other.
struct Barometer {
  HeightSample sample;
};
using FlightMessage =
    std::variant<LaserScan, PointCloud, ImuSample, HeightSample, Barometer, TruePose, TrueWalkers>;

struct TrueBiases {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();           ///< rad/s, in the IMU
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s²
};

struct FlightEvent {
  double stamp = 0.0;    ///< of the message, s
  double arrival = 0.0;  ///< when it reaches the computer, s
  FlightMessage message;
  bool second_laser = false;  ///< a LaserScan of VehicleModel::second_laser
};

/// Stamp of the start of every simulated flight, s.
constexpr double kFlightStart = 1.4e9;

/// Everything that the vehicle's sensors send on a flight, in the order of arrival. The same seed
/// gives the same messages; each sensor has random numbers of its own, so that one sensor more does
/// not change the others.
class FlightSimulator {
 public:
  /// `world` and `motion` must outlive the simulator.
  FlightSimulator(const World& world, const Motion& motion, const VehicleModel& vehicle,
                  std::uint64_t seed);
  ~FlightSimulator();

  /// False at the end.
  bool next(FlightEvent& event);

  /// Of the IMU now; zero without one.
  TrueBiases imuBiases() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
