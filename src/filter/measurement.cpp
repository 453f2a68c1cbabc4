// SPDX-License-Identifier: BSD-3-Clause
#include "measurement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "covariance_intersection.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/square.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {
namespace {

const char* const kGated = "innovation gate";

/// For two estimates with unknown correlation, the covariance of their difference is at most twice
/// the sum of their covariances.
constexpr double kAnyCorrelation = 2.0;

/// At larger tilts the range finder may hit a wall.
const double kMinCosine = std::cos(degToRad(45.0));
/// Ground levels that differ by less are equal, m.
constexpr double kSameLevel = 0.1;
/// No vehicle climbs faster, m/s. After a longer pause any change of the distance may be a step of
/// the surface below, s.
constexpr double kMaxClimb = 3.0, kMaxRangePause_s = 1.0;
/// Standard deviation of the floor height when the floor is detected again, m.
constexpr double kFloorSigma = 0.01;
/// Uncertainty before a reinitialization.
constexpr double kUnknownM = 1e3, kUnknownRad = 1e2;
/// Error of the gyro bias at a standstill, in addition to the noise over one second, rad/s.
constexpr double kStandstillRate = 5e-4;

/// A standstill is only accepted if the speed is known with this standard deviation, m/s.
constexpr double kKnownSpeed = 0.3;

void makeSymmetric(FilterState& state) {
  state.covariance = (0.5 * (state.covariance + state.covariance.transpose())).eval();
}

/// Any number of rows in one type, and products without blocking: with fixed sizes this file took a
/// minute to compile.
constexpr int kMostRows = 6;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kStateDim, Eigen::ColMajor, kMostRows>;
using Columns =
    Eigen::Matrix<double, kStateDim, Eigen::Dynamic, Eigen::ColMajor, kStateDim, kMostRows>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostRows>;
using Square =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostRows, kMostRows>;

/// covariance * jacobian'. Most of a jacobian is zero.
Columns crossCovariance(const StateMatrix& covariance, const Rows& jacobian) {
  Columns cross = Columns::Zero(kStateDim, jacobian.rows());
  for (Eigen::Index row = 0; row < jacobian.rows(); ++row) {
    for (Eigen::Index i = 0; i < kStateDim; ++i)
      if (jacobian(row, i) != 0.0) cross.col(row) += jacobian(row, i) * covariance.col(i);
  }
  return cross;
}

/// Adds factor * a * b'.
void addProduct(double factor, const Columns& a, const Columns& b, StateMatrix& sum) {
  for (Eigen::Index column = 0; column < kStateDim; ++column) {
    for (Eigen::Index i = 0; i < a.cols(); ++i)
      sum.col(column) += (factor * b(column, i)) * a.col(i);
  }
}

/// A linearized measurement, and what the gate and the update need of the state.
struct Innovation {
  template <int Size>
  Innovation(const Linearized<Size>& z, const FilterState& state)
      : value(z.innovation), jacobian(z.jacobian) {
    cross = crossCovariance(state.covariance, jacobian);
    covariance = jacobian.lazyProduct(cross);
  }

  Vector value;
  Rows jacobian;
  Columns cross;      ///< covariance of the state and the prediction
  Square covariance;  ///< of the prediction
};

bool passes(const Innovation& z, const Square& noise, double factor,
            const PoseFilterConfig& config) {
  const Square covariance = factor * (z.covariance + noise);
  const Vector weighted = covariance.ldlt().solve(z.value);
  return z.value.dot(weighted) <=
         chiSquareQuantile(config.gate.probability, static_cast<int>(z.value.size()));
}

void update(const Innovation& z, const Square& noise, FilterState& state) {
  const Square inverse = (z.covariance + noise).inverse();
  const Columns gain = z.cross.lazyProduct(inverse);
  addProduct(-1.0, gain, z.cross, state.covariance);
  makeSymmetric(state);
  inject(gain.lazyProduct(z.value), state);
}

Verdict updateGated(const Innovation& z, const Square& noise, const PoseFilterConfig& config,
                    FilterState& state) {
  if (!passes(z, noise, 1.0, config)) return {kGated};
  update(z, noise, state);
  return {};
}

/// Of a measurement of one value.
Square squareOf(double variance) { return Square::Constant(1, 1, variance); }

/// In one dimension covariance intersection selects the better of the two. Needed because the
/// errors of a magnetometer are correlated over time.
Verdict updateIntersected(const Innovation& z, double variance, const PoseFilterConfig& config,
                          FilterState& state) {
  const double prior = z.covariance(0);
  if (!passes(z, squareOf(variance), kAnyCorrelation, config)) return {kGated};
  if (prior > variance) update(z, squareOf(prior * variance / (prior - variance)), state);
  return {};
}

/// Replaces the measured states by the covariance intersection, and updates all other states
/// according to their correlation.
template <int Size>
void updateIntersected(const Innovation& z, const Square& measured, FilterState& state) {
  const Eigen::Matrix<double, Size, Size> prior = z.covariance, other = measured;
  const Intersection<Size> fused =
      intersect<Size>(0.5 * (prior + prior.transpose()), 0.5 * (other + other.transpose()));
  if (fused.weight >= 1.0) return;
  const Square inverse = prior.inverse(), change = fused.covariance - prior, gain = fused.gain;
  const Columns regression = z.cross.lazyProduct(inverse);
  const Columns changed = regression.lazyProduct(change);
  const Vector step = gain.lazyProduct(z.value);
  addProduct(1.0, changed, regression, state.covariance);
  makeSymmetric(state);
  inject(regression.lazyProduct(step), state);
}

template <int Size>
bool fusePose(const Linearized<Size>& linearized, const Square& noise,
              const PoseFilterConfig& config, FilterState& state) {
  const Innovation z(linearized, state);
  if (!passes(z, noise, kAnyCorrelation, config)) return false;
  updateIntersected<Size>(z, noise, state);
  return true;
}

/// Fuses a pose, or only what is measured of it: the position across the unobservable direction,
/// and the yaw. Along that direction the pose is a prediction, often that of this filter.
bool fusePose(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  const Linearized<3> z = linearizePose(m, state);
  if (m.unobservable.isZero()) return fusePose<3>(z, m.covariance, config, state);
  const Eigen::Vector2d along = m.unobservable.normalized();
  Eigen::Matrix<double, 2, 3> measured;
  measured << -along.y(), along.x(), 0.0, 0.0, 0.0, 1.0;
  const Linearized<2> part{measured * z.innovation, measured.lazyProduct(z.jacobian)};
  return fusePose<2>(part, measured * m.covariance * measured.transpose(), config, state);
}

/// Reinitializes to a pose as if no pose had been known. The motion relative to the vehicle is
/// kept: the velocity rotates with the yaw.
void reinitialize(const Measurement& m, FilterState& state) {
  const double turn = normalizeAngle(m.value.z() - yawOf(state.map_R_base));
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
  state.map_R_base = (rotation * state.map_R_base).normalized();
  state.velocity = rotation * state.velocity;
  state.position.head<2>() = m.value.head<2>();
  for (const int block : {kOrientation, kPosition, kVelocity}) {
    state.covariance.middleRows<3>(block) = matrix * state.covariance.middleRows<3>(block);
    state.covariance.middleCols<3>(block) =
        state.covariance.middleCols<3>(block) * matrix.transpose();
  }
  StateVector yaw_error = StateVector::Zero();
  yaw_error(kOrientation + 2) = 1.0;
  yaw_error.segment<3>(kVelocity) = Eigen::Vector3d::UnitZ().cross(state.velocity);
  state.covariance += square(kUnknownRad) * yaw_error * yaw_error.transpose();
  state.covariance(kPosition, kPosition) += square(kUnknownM);
  state.covariance(kPosition + 1, kPosition + 1) += square(kUnknownM);
  update({linearizePose(m, state), state}, m.covariance, state);
  state.reinitialized = true;
}

Verdict applyPose(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  Verdict verdict;
  if (!state.reinitialized || m.bypass_gate) {
    reinitialize(m, state);
  } else if (!fusePose(m, config, state)) {
    if (state.rejected_since < 0.0) state.rejected_since = m.stamp;
    if (m.stamp - state.rejected_since < config.gate.reinitialize_after_s) return {kGated};
    reinitialize(m, state);
    // The velocity was probably wrong, too: in a uniform motion that looked like a standstill.
    const double speed = square(config.motion.start_speed_sigma);
    state.covariance.block<2, 2>(kVelocity, kVelocity).diagonal().array() += speed;
    verdict.reinitialized = true;
  }
  state.rejected_since = -1.0;
  if (m.unobservable.isZero()) {
    state.aided_stamp = m.stamp;
  } else {
    state.partly_aided_stamp = m.stamp;
  }
  return verdict;
}

/// Whether the surface below has a step: the distance changes faster than the vehicle climbs. Where
/// it has an edge, a reading may lie between both levels, so that the step comes in two parts.
bool isJump(double stamp, double down_m, const FilterState& state) {
  constexpr double kSigmas = 3.0;
  const double seconds = stamp - state.range_stamp;
  const double climb = std::abs(state.velocity.z()) +
                       kSigmas * std::sqrt(state.covariance(kVelocity + 2, kVelocity + 2));
  return seconds > kMaxRangePause_s ||
         std::abs(down_m - state.range_m) >
             std::min(climb, kMaxClimb) * std::abs(seconds) + kSameLevel;
}

void resetVariance(int index, double variance, FilterState& state) {
  state.covariance.row(index).setZero();
  state.covariance.col(index).setZero();
  state.covariance(index, index) = variance;
}

/// The new level is the floor if the reading agrees with it, else a new level, whose height is
/// estimated.
void stepTo(const Measurement& m, double ground, const PoseFilterConfig& config,
            FilterState& state) {
  const Square noise = squareOf(m.covariance(0, 0));
  state.ground = 0.0;
  resetVariance(kGround, square(kFloorSigma), state);
  if (!passes({linearizeRange(m, state), state}, noise, 1.0, config)) {
    state.ground = ground;
    resetVariance(kGround, square(config.height.range_max_m), state);
  }
  update({linearizeRange(m, state), state}, noise, state);
}

/// Reinitializes the height to the range finder.
void reinitializeHeight(const Measurement& m, FilterState& state) {
  resetVariance(kPosition + 2, square(kUnknownM), state);
  resetVariance(kVelocity + 2, square(kMaxClimb), state);
  update({linearizeRange(m, state), state}, squareOf(m.covariance(0, 0)), state);
}

/// The floor is at z = 0. If a reading does not fit, there may be a step of the surface below,
/// which the next readings confirm; otherwise the height of the filter is wrong.
Verdict applyRange(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  const double cosine = (state.map_R_base * Eigen::Vector3d::UnitZ()).z();
  if (cosine < kMinCosine) return {"tilted"};
  const Square noise = squareOf(m.covariance(0, 0));
  const double down = m.value.x() * cosine, ground = state.position.z() - down;
  const bool jump = isJump(m.stamp, down, state);
  state.range_stamp = m.stamp;
  state.range_m = down;
  if (passes({linearizeRange(m, state), state}, noise, 1.0, config)) {
    update({linearizeRange(m, state), state}, noise, state);
    state.step_readings = 0;
    state.height_rejected_since = -1.0;
    return {};
  }
  const bool agrees = state.step_readings > 0 && std::abs(ground - state.step_height) < kSameLevel;
  state.step_readings = agrees ? state.step_readings + 1 : jump ? 1 : 0;
  state.step_height = ground;
  if (state.height_rejected_since < 0.0) state.height_rejected_since = m.stamp;
  const bool steps = state.step_readings >= config.height.step_readings;
  const bool wrong = m.stamp - state.height_rejected_since >= config.gate.reinitialize_after_s;
  if (!steps && !wrong) return {state.step_readings > 0 ? "step below" : kGated};
  if (steps) {
    stepTo(m, ground, config, state);
  } else {
    reinitializeHeight(m, state);
  }
  state.step_readings = 0;
  state.height_rejected_since = -1.0;
  return {"", !steps};
}

/// The gate is needed because a smooth flight at constant speed looks like a standstill to an IMU.
Verdict applyStandstill(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  const double variance = state.covariance.diagonal().segment<3>(kVelocity).maxCoeff();
  if (variance > square(kKnownSpeed)) return {"speed unknown"};
  Square noise = Square::Zero(6, 6);
  noise.diagonal().head<3>().setConstant(square(config.motion.zero_velocity_sigma));
  noise.diagonal().tail<3>().setConstant(square(config.noise.gyro_noise) + square(kStandstillRate));
  return updateGated({linearizeStandstill(m, state), state}, noise, config, state);
}

/// With poses, velocity and tilt are known much better than from the assumption that the vehicle
/// does not accelerate.
Verdict applyGravity(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  if (m.stamp - state.aided_stamp < config.gate.coast_after_s) return {"not needed"};
  return updateGated({linearizeGravity(m, state), state}, m.covariance, config, state);
}

Verdict applyPosition(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  const Verdict verdict =
      updateGated({linearizePosition(m, state), state}, m.covariance, config, state);
  if (verdict.reason.empty()) state.aided_stamp = m.stamp;
  return verdict;
}

}  // namespace

double chiSquareQuantile(double probability, int freedom) {
  // Inverse of the normal distribution (Abramowitz and Stegun, 26.2.23).
  const double tail = std::min(probability, 1.0 - probability);
  const double t = std::sqrt(-2.0 * std::log(std::max(tail, 1e-300)));
  const double size = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                              (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  const double z = probability >= 0.5 ? size : -size;
  const double c = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - c + z * std::sqrt(c), 3.0);
}

Verdict apply(const Measurement& m, const PoseFilterConfig& config, FilterState& state) {
  const Square noise = squareOf(m.covariance(0, 0));
  switch (m.sensor) {
    case FilterSensor::kPose:
      return applyPose(m, config, state);
    case FilterSensor::kRange:
      return applyRange(m, config, state);
    case FilterSensor::kFloorBeams:
      return updateGated({linearizeFloorHeight(m, state), state}, noise, config, state);
    case FilterSensor::kBarometer:
      return updateGated({linearizeBarometer(m, state), state}, noise, config, state);
    case FilterSensor::kYaw:
      return updateIntersected({linearizeYaw(m, state), state}, noise(0), config, state);
    case FilterSensor::kPosition:
      return applyPosition(m, config, state);
    case FilterSensor::kGravityDirection:
      return applyGravity(m, config, state);
    case FilterSensor::kZeroVelocity:
      return applyStandstill(m, config, state);
  }
  return {"unknown sensor"};
}

}  // namespace kestrel
