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

/// An IMU with a built-in attitude filter (Xsens MTi class). Defaults are data sheet values.
struct ImuModel {
  double rate_hz = 100.0;
  double gyro_noise = 0.0009;               ///< noise density, rad/s/sqrt(Hz)
  double gyro_bias = 0.003;                 ///< standard deviation of the initial bias, rad/s
  double gyro_bias_walk = 0.00002;          ///< rad/s²/sqrt(Hz)
  double accelerometer_noise = 0.002;       ///< noise density, m/s²/sqrt(Hz)
  double accelerometer_bias = 0.02;         ///< standard deviation of the initial bias, m/s²
  double accelerometer_bias_walk = 0.0001;  ///< m/s³/sqrt(Hz)
  double misalignment_rad = 0.002;    ///< standard deviation of the mounting error about each axis
  double attitude_sigma_rad = 0.005;  ///< standard deviation of the error of roll and pitch
  double attitude_time_s = 5.0;       ///< correlation time of the attitude error
  double yaw_sigma_rad = 0.05;        ///< standard deviation of the yaw error (magnetometer)
  double latency_s = 0.005;
  bool gives_orientation = true;  ///< false: a raw IMU
};

/// A range finder that looks along the base's negative z axis.
struct RangeFinderModel {
  double rate_hz = 20.0;
  double sigma_m = 0.01;
  double range_min = 0.05, range_max = 6.0;  ///< m
  double latency_s = 0.01;
};

/// A barometer that measures the height of the base above the floor.
struct BarometerModel {
  double rate_hz = 10.0;
  double sigma_m = 0.1;
  double drift_m_per_sqrt_s = 0.02;
  double latency_s = 0.02;
};

/// An obstacle close to the laser that covers a part of its view for some time. Applies to every 2D
/// laser of the vehicle.
struct BlockedView {
  double from_s = 0.0, until_s = 0.0;       ///< since the start of the flight
  double first_rad = -kPi, last_rad = kPi;  ///< bearings of the covered beams, in the laser frame
  double range_m = 0.4;                     ///< range that the covered beams measure
};

/// The sensors of the vehicle and the properties of its data link.
struct VehicleModel {
  std::optional<LaserModel> laser;
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  /// Its sweeps start half a period after those of `laser`.
  std::optional<LaserModel> second_laser;
  Eigen::Isometry3d base_T_second_laser = Eigen::Isometry3d::Identity();
  std::optional<LidarModel> lidar;
  Eigen::Isometry3d base_T_lidar = Eigen::Isometry3d::Identity();
  std::optional<ImuModel> imu = ImuModel();
  Eigen::Quaterniond base_R_imu = Eigen::Quaterniond::Identity();
  std::optional<RangeFinderModel> range_finder = RangeFinderModel();
  std::optional<BarometerModel> barometer = BarometerModel();
  double truth_rate_hz = 100.0;   ///< of the TruePose messages; 0: none
  double scan_latency_s = 0.005;  ///< from the last beam of a sweep to the arrival
  double stamp_jitter_s = 0.0;    ///< standard deviation of the error of the stamps
  double loss_probability = 0.0;  ///< for each message of a sensor
  std::vector<BlockedView> blocked_views;
};

/// A small quadrotor with IMU, range finder, barometer and the laser or lidar called `sensor`.
/// Throws std::invalid_argument, which lists the valid names.
VehicleModel quadrotorWith(const std::string& sensor);

/// True positions of the walking people.
struct TrueWalkers {
  std::vector<Eigen::Vector2d> positions;  ///< in world, in the order of World::Parts::walkers
};

/// True state of the vehicle.
struct TruePose {
  TrueState state;
};

/// A reading of the barometer. (A plain HeightSample is a reading of the range finder.)
struct Barometer {
  HeightSample sample;
};
/// Any message of a simulated flight.
using FlightMessage =
    std::variant<LaserScan, PointCloud, ImuSample, HeightSample, Barometer, TruePose, TrueWalkers>;

/// True biases of the IMU.
struct TrueBiases {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();           ///< rad/s, in the IMU frame
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s², in the IMU frame
};

/// A message together with its times.
struct FlightEvent {
  double stamp = 0.0;    ///< of the message, s
  double arrival = 0.0;  ///< time when it reaches the computer, s
  FlightMessage message;
  bool second_laser = false;  ///< true: a LaserScan of VehicleModel::second_laser
};

/// Time stamp at which every simulated flight starts, s.
constexpr double kFlightStart = 1.4e9;

/// Produces all sensor messages of a flight in the order of their arrival. The same seed gives the
/// same messages. Each sensor has its own random number generator, so that adding a sensor does not
/// change the messages of the others.
class FlightSimulator {
 public:
  /// `world` and `motion` must outlive the simulator. Throws std::invalid_argument if a sensor's
  /// rate is not positive.
  FlightSimulator(const World& world, const Motion& motion, const VehicleModel& vehicle,
                  std::uint64_t seed);
  ~FlightSimulator();

  /// Writes the next message to `event`. Returns false at the end of the flight.
  bool next(FlightEvent& event);

  /// Current biases of the IMU; zero without an IMU.
  TrueBiases imuBiases() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
