// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {

/// A smooth flight with exact ground truth: at rest, then curves with roll, pitch and yaw.
struct FilterFlight {
  double rest_s = 1.5;
  Eigen::Vector3d gyro_bias = {0.004, -0.003, 0.002};
  Eigen::Vector3d accelerometer_bias = {0.02, -0.01, 0.03};
  double start_stamp = 1000.0;
  Eigen::Isometry3d base_T_imu = Eigen::Isometry3d::Identity();

  struct Truth {
    Eigen::Vector3d position;
    Eigen::Vector3d velocity;
    Eigen::Quaterniond map_R_base;
    double yaw() const { return yawOf(map_R_base); }
  };

  /// Time parameter of the motion, which starts slowly.
  double progress(double time) const {
    const double t = std::max(0.0, time - rest_s);
    return t - std::tanh(t);
  }

  Eigen::Vector3d position(double time) const {
    const double s = progress(time);
    return {1.5 * std::sin(0.7 * s), 1.0 - std::cos(0.5 * s), 1.0 + 0.3 * std::sin(0.4 * s)};
  }

  Eigen::Quaterniond rotation(double time) const {
    const double s = progress(time);
    return Eigen::AngleAxisd(0.8 * std::sin(0.3 * s), Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(0.15 * std::sin(0.9 * s), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(0.12 * std::sin(1.1 * s), Eigen::Vector3d::UnitX());
  }

  Truth at(double time) const {
    constexpr double kStep = 1e-4;
    return {position(time), (position(time + kStep) - position(time - kStep)) / (2.0 * kStep),
            rotation(time)};
  }

  /// An IMU sample without noise, but with the biases.
  ImuSample imu(double time) const {
    constexpr double kStep = 1e-3;
    const auto place = [&](double t) -> Eigen::Vector3d {  // position of the IMU
      return position(t) + rotation(t) * base_T_imu.translation();
    };
    const Eigen::Vector3d acceleration =
        (place(time + kStep) - 2.0 * place(time) + place(time - kStep)) / (kStep * kStep);
    const Eigen::Matrix3d imu_R_base = base_T_imu.linear().transpose();
    const Eigen::AngleAxisd turn(rotation(time - kStep).conjugate() * rotation(time + kStep));
    ImuSample sample;
    sample.stamp = start_stamp + time;
    sample.angular_velocity = imu_R_base * (turn.axis() * turn.angle() / (2.0 * kStep) + gyro_bias);
    sample.linear_acceleration =
        imu_R_base *
        (rotation(time).conjugate() * (acceleration + Eigen::Vector3d(0.0, 0.0, 9.81)) +
         accelerometer_bias);
    return sample;
  }

  PoseMeasurement pose(double time) const {
    const Truth truth = at(time);
    PoseMeasurement m;
    m.stamp = start_stamp + time;
    m.pose = Pose2(truth.position.x(), truth.position.y(), truth.yaw());
    m.covariance.diagonal() << 2.5e-5, 2.5e-5, 1e-5;
    return m;
  }

  HeightSample range(double time) const {
    const Truth truth = at(time);
    const double up = (truth.map_R_base * Eigen::Vector3d::UnitZ()).z();
    return {start_stamp + time, truth.position.z() / up};
  }
};

/// How a flight is fed to the filter. Every hook may change a message; if it returns false the
/// message is dropped.
struct Feeding {
  double imu_hz = 100.0;
  int per_pose = 4, per_range = 5;  ///< in IMU samples; 0: none
  double pose_late_s = 0.02;        ///< delay, a multiple of the IMU period
  double from_s = 0.0, until_s = 20.0;
  double gyro_noise = 0.009, accelerometer_noise = 0.02;  ///< of one sample
  double pose_noise_m = 0.002, range_noise_m = 0.01;
  std::function<bool(double, ImuSample&)> imu;
  std::function<bool(double, PoseMeasurement&)> pose;
  std::function<bool(double, HeightSample&)> range;
  std::function<void(double, const FilterOutput&)> output;
};

inline void feed(const FilterFlight& flight, const Feeding& feeding, PoseFilter& filter) {
  Random random(7);
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(sigma * random.gaussian(), sigma * random.gaussian(),
                           sigma * random.gaussian());
  };
  const int first = static_cast<int>(std::lround(feeding.from_s * feeding.imu_hz));
  const int count = static_cast<int>(std::lround(feeding.until_s * feeding.imu_hz));
  const int late = static_cast<int>(std::lround(feeding.pose_late_s * feeding.imu_hz));
  for (int i = first; i < count; ++i) {
    const double time = i / feeding.imu_hz;
    ImuSample sample = flight.imu(time);
    *sample.angular_velocity += noise(feeding.gyro_noise);
    *sample.linear_acceleration += noise(feeding.accelerometer_noise);
    const Eigen::Vector3d pose_noise = noise(feeding.pose_noise_m);
    const double range_noise = noise(feeding.range_noise_m).x();
    if ((!feeding.imu || feeding.imu(time, sample)) && filter.addImu(sample, flight.base_T_imu) &&
        feeding.output) {
      feeding.output(time, *filter.output());
    }
    if (feeding.per_range > 0 && i % feeding.per_range == 0) {
      HeightSample range = flight.range(time);
      range.height_m += range_noise;
      if (!feeding.range || feeding.range(time, range)) filter.addRange(range);
    }
    const int taken = i - late;
    if (feeding.per_pose > 0 && taken >= first && taken % feeding.per_pose == 0) {
      PoseMeasurement pose = flight.pose(taken / feeding.imu_hz);
      pose.pose = Pose2(pose.pose.x + pose_noise.x(), pose.pose.y + pose_noise.y(),
                        pose.pose.yaw + 0.5 * pose_noise.z());
      if (!feeding.pose || feeding.pose(time, pose)) filter.addPose(pose);
    }
  }
}

/// Errors of an output compared with the truth at its stamp.
struct FilterErrors {
  double position_m, velocity, tilt_rad, yaw_rad;
};

inline FilterErrors errorsOf(const FilterFlight& flight, const FilterOutput& output) {
  const FilterFlight::Truth truth = flight.at(output.stamp - flight.start_stamp);
  const Eigen::Quaterniond found(output.map_T_base.linear());
  const Eigen::Vector3d up = truth.map_R_base.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d found_up = found.conjugate() * Eigen::Vector3d::UnitZ();
  return {(output.map_T_base.translation() - truth.position).norm(),
          (output.velocity - truth.velocity).norm(), std::asin(up.cross(found_up).norm()),
          std::abs(std::remainder(yawOf(found) - truth.yaw(), 2.0 * 3.14159265358979))};
}

/// `time`: since the beginning of the flight, s.
inline FilterStatus statusAtEnd(const PoseFilter& filter, const FilterFlight& flight, double time) {
  return filter.status(flight.start_stamp + time);
}

}  // namespace kestrel
