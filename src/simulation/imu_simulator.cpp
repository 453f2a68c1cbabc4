// SPDX-License-Identifier: BSD-3-Clause
#include "imu_simulator.h"

#include <cmath>

#include "kestrel_slam/geometry/gravity.h"

namespace kestrel {
namespace {

Eigen::Quaterniond rotation(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

}  // namespace

ImuSimulator::ImuSimulator(const ImuModel& model, const Eigen::Quaterniond& base_R_imu,
                           std::uint64_t seed)
    : model_(model), random_(seed) {
  base_R_imu_ = base_R_imu.normalized() * rotation(normal(model.misalignment_rad));
  gyro_bias_ = normal(model.gyro_bias);
  accelerometer_bias_ = normal(model.accelerometer_bias);
  attitude_error_ = normal(1.0).cwiseProduct(
      Eigen::Vector3d(model.attitude_sigma_rad, model.attitude_sigma_rad, model.yaw_sigma_rad));
}

Eigen::Vector3d ImuSimulator::normal(double sigma) {
  Eigen::Vector3d result;
  for (double& axis : result) axis = sigma * random_.gaussian();
  return result;
}

double ImuSimulator::gaussMarkovStep(double value, double sigma) {
  const double decay = std::exp(-1.0 / (model_.rate_hz * model_.attitude_time_s));
  return decay * value + sigma * std::sqrt(1.0 - decay * decay) * random_.gaussian();
}

ImuSample ImuSimulator::next(const TrueState& truth) {
  const Eigen::Quaterniond world_R_base(truth.world_T_base.linear());
  const Eigen::Quaterniond imu_R_base = base_R_imu_.conjugate();
  // White noise grows with the root of the rate; a random walk with the root of the time step.
  const double noise = std::sqrt(model_.rate_hz), walk = 1.0 / noise;
  ImuSample sample;
  sample.angular_velocity =
      imu_R_base * truth.angular_velocity + gyro_bias_ + normal(model_.gyro_noise * noise);
  sample.linear_acceleration =
      imu_R_base *
          (world_R_base.conjugate() * (truth.acceleration + kGravity * Eigen::Vector3d::UnitZ())) +
      accelerometer_bias_ + normal(model_.accelerometer_noise * noise);
  gyro_bias_ += normal(model_.gyro_bias_walk * walk);
  accelerometer_bias_ += normal(model_.accelerometer_bias_walk * walk);

  const Eigen::Quaterniond yaw_error = rotation({0.0, 0.0, attitude_error_.z()});
  const Eigen::Quaterniond tilt_error = rotation({attitude_error_.x(), attitude_error_.y(), 0.0});
  if (model_.gives_orientation) {
    sample.world_R_imu = (yaw_error * world_R_base * tilt_error * base_R_imu_).normalized();
  }
  attitude_error_.x() = gaussMarkovStep(attitude_error_.x(), model_.attitude_sigma_rad);
  attitude_error_.y() = gaussMarkovStep(attitude_error_.y(), model_.attitude_sigma_rad);
  attitude_error_.z() = gaussMarkovStep(attitude_error_.z(), model_.yaw_sigma_rad);
  return sample;
}

}  // namespace kestrel
