// SPDX-License-Identifier: BSD-3-Clause
#include "initializer.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/square.h"
#include "measurement.h"

namespace kestrel {
namespace {

constexpr double kInAir_s = 1.1;  // without a standstill for this long, the vehicle is in flight
// Allowed relative difference between the mean specific force and gravity.
constexpr double kGravityShare = 0.4;

constexpr double kTiltSigma = 0.2;        // before the gravity update, rad
constexpr double kGroundGravity = 0.005;  // error of the mean of gravity at a standstill, m/s²
constexpr double kAirGravity = 0.5;       // the same in flight, m/s²
constexpr double kGroundGyro = 5e-4;      // motion of a vehicle at a standstill, rad/s
constexpr double kStartM = 0.01;  // the initial pose defines the map if no other pose is given
constexpr double kStartRad = 0.002;
constexpr double kUnknownOffset = 1e3;  // offset of a barometer, m
// Factor for the bias uncertainty of an IMU that has failed.
constexpr double kUncertainBiasFactor = 20.0;

template <int Size>
void setVariance(int block, double sigma, StateMatrix& covariance) {
  covariance.diagonal().segment<Size>(block).setConstant(square(sigma));
}

/// Updates tilt and accelerometer bias together, because gravity alone cannot separate them.
void applyGravity(const Eigen::Vector3d& force, double sigma, FilterState& state) {
  Measurement gravity;
  gravity.value = force;
  const Linearized<3> z = linearizeGravity(gravity, state);
  const Eigen::Matrix<double, kStateDim, 3> cross =
      state.covariance.lazyProduct(z.jacobian.transpose());
  const Eigen::Matrix3d total =
      z.jacobian.lazyProduct(cross) + square(sigma) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, kStateDim, 3> gain = cross * total.inverse();
  state.covariance -= gain * cross.transpose();
  state.covariance = (0.5 * (state.covariance + state.covariance.transpose())).eval();
  inject(gain * z.innovation, state);
}

std::string gravityProblem(const Eigen::Vector3d& force) {
  std::ostringstream text;
  text.precision(3);
  if (!(std::abs(force.norm() - kGravity) <= kGravityShare * kGravity)) {
    text << "the accelerometer measures " << force.norm() << " m/s² on average instead of "
         << kGravity << "; check its unit (m/s², not g) and whether it includes gravity";
  } else if (force.z() < 0.0) {
    text << "gravity has the wrong sign: the accelerometer measures " << force.z()
         << " m/s² along the base's z axis, but it must be about +" << kGravity
         << " at rest (REP-145); check the sign of the driver, or the mounting of the IMU";
  }
  return text.str();
}

}  // namespace

Initializer::Initializer(const PoseFilterConfig& config)
    : config_(config), attitude_(AttitudeConfig()) {}

void Initializer::restart(const std::optional<FilterState>& learned) {
  const std::optional<FilterState> kept = learned;  // may be a reference to our own member
  const PoseFilterConfig config = config_;
  *this = Initializer(config);
  learned_ = kept;
}

void Initializer::restartWithUncertainBiases() {
  restart();
  biases_uncertain_ = true;
}

std::optional<FilterState> Initializer::add(double stamp, const Eigen::Vector3d& rate,
                                            const Eigen::Vector3d& force) {
  if (count_ == 0) first_stamp_ = last_stamp_ = stamp;
  ++count_;
  force_sum_ += force;
  const std::vector<EstimatedAttitude>& known = attitude_.add(stamp, rate, force);
  if (!known.empty()) estimated_ = known.back().world_R_base;
  const std::optional<Eigen::Vector3d> mean = standstill_.add(stamp - last_stamp_, rate, force);
  last_stamp_ = stamp;
  const bool flies = stamp - first_stamp_ >= kInAir_s;
  if (!mean && !flies) return std::nullopt;
  if (!accepts(force_sum_ / count_) || (!mean && !estimated_)) {
    const std::string problem = problem_;
    const bool biases_uncertain = biases_uncertain_;
    restart(learned_);
    problem_ = problem;
    biases_uncertain_ = biases_uncertain;
    return std::nullopt;
  }
  return mean ? onGround(stamp, *mean) : inAir(stamp, *estimated_);
}

bool Initializer::accepts(const Eigen::Vector3d& force) {
  problem_ = gravityProblem(force);
  return problem_.empty();
}

FilterState Initializer::initialState(double stamp, const Eigen::Quaterniond& map_R_base) const {
  const double factor = biases_uncertain_ ? kUncertainBiasFactor : 1.0;
  FilterState state;
  state.stamp = stamp;
  state.map_R_base = map_R_base;
  StateMatrix& p = state.covariance;
  setVariance<3>(kOrientation, kTiltSigma, p);
  setVariance<1>(kOrientation + 2, kStartRad, p);
  setVariance<2>(kPosition, kStartM, p);
  setVariance<1>(kPosition + 2, config_.height.initial_sigma_m, p);
  setVariance<3>(kGyroBias, factor * config_.noise.gyro_bias_sigma, p);
  setVariance<3>(kAccelerometerBias, factor * config_.noise.accelerometer_bias_sigma, p);
  setVariance<1>(kBarometerOffset, kUnknownOffset, p);
  if (learned_) {
    state.gyro_bias = learned_->gyro_bias;
    state.accelerometer_bias = learned_->accelerometer_bias;
    p.block<6, 6>(kGyroBias, kGyroBias) = learned_->covariance.block<6, 6>(kGyroBias, kGyroBias);
  }
  return state;
}

FilterState Initializer::onGround(double stamp, const Eigen::Vector3d& rate) {
  in_air_ = false;
  const Eigen::Vector3d force = force_sum_ / count_;
  FilterState state = initialState(stamp, leveled(force));
  setVariance<3>(kVelocity, config_.motion.zero_velocity_sigma, state.covariance);
  state.gyro_bias = rate;
  state.covariance.middleRows<3>(kGyroBias).setZero();
  state.covariance.middleCols<3>(kGyroBias).setZero();
  setVariance<3>(kGyroBias, std::hypot(config_.noise.gyro_noise, kGroundGyro), state.covariance);
  applyGravity(force, kGroundGravity, state);
  return state;
}

FilterState Initializer::inAir(double stamp, const Eigen::Quaterniond& map_R_base) {
  in_air_ = true;
  FilterState state = initialState(stamp, withoutYaw(map_R_base));
  setVariance<3>(kVelocity, config_.motion.start_speed_sigma, state.covariance);
  const Eigen::Vector3d up = state.map_R_base.conjugate() * Eigen::Vector3d::UnitZ();
  applyGravity(kGravity * up + state.accelerometer_bias, kAirGravity, state);
  return state;
}

}  // namespace kestrel
