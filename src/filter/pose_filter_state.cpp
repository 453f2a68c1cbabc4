// SPDX-License-Identifier: BSD-3-Clause
#include "pose_filter_state.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/square.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/attitude_estimator.h"

namespace kestrel {
namespace {

// Rad/s; above, an IMU off the rotation axis measures centripetal acceleration.
constexpr double kModerateRate = 3.0;
constexpr double kFreshHeight_s = 0.5;  // an older range is not used for the initial height
/// Share of the variance of x, y and yaw that is due to the map. It does not affect velocity and
/// biases: in a shifted map they are measured equally well. Tuned with the random flights of
/// measure_filter, and checked with other seeds.
constexpr double kMapShare = 0.2;

/// Standard deviation of the height over the surface below, m.
double heightSigma(const FilterState& state) {
  constexpr int kZ = kPosition + 2;
  const StateMatrix& p = state.covariance;
  return std::sqrt(std::max(0.0, p(kZ, kZ) + p(kGround, kGround) - 2.0 * p(kZ, kGround)));
}

/// Covariance intersection keeps the correlation of velocity and biases with the pose as if the
/// whole error of the pose had accumulated in flight. This removes the part that is due to the map.
void separateMap(FilterCovariance& covariance) {
  constexpr int kYawXY = kOrientation + 2;  // the three states that the mapper measures
  const double rest = std::sqrt(1.0 - kMapShare);
  const Eigen::Matrix3d pose_covariance = covariance.block<3, 3>(kYawXY, kYawXY);
  covariance.middleRows<3>(kYawXY) *= rest;
  covariance.middleCols<3>(kYawXY) *= rest;
  covariance.block<3, 3>(kYawXY, kYawXY) = pose_covariance;
}

}  // namespace

PoseFilter::State::State(const PoseFilterConfig& c)
    : config(c),
      imu(c),
      initializer(c),
      timeline(c, [this](const auto& m, const auto& v) { judge(m, v); }) {}

bool PoseFilter::State::addImu(const CheckedImu& checked) {
  ++status.imu.received;
  contradiction = checked.contradiction ? checked.contradiction->message : "";
  if (checked.converted != gyro_converted) {  // the biases so far have another unit
    gyro_converted = checked.converted;
    reset("unit of the gyro", true);
  }
  const ImuIntake::Result result = imu.add(checked);
  if (result == ImuIntake::Result::kRejected) {
    ++status.imu.rejected[imu.fault().reason];
    return false;
  }
  ++status.imu.accepted;
  if (result == ImuIntake::Result::kMerged) return false;
  if (result == ImuIntake::Result::kClockSetBack) {
    timeline.clear();
    reset("clock set back", false);
  }
  const ImuStep& step = imu.step();
  reading = step.reading;
  if (step.dt > config.imu.max_gap_s) {
    if (!timeline.empty()) {
      const FilterState learned = timeline.newest().state;
      reset("gap of the IMU", false);
      initializer.restart(learned);
    } else {
      initializer.restart();
    }
  }
  if (timeline.empty()) return begin(step);
  advance(step);
  return !timeline.empty();
}

/// Collects samples. Returns true if the filter is now initialized.
bool PoseFilter::State::begin(const ImuStep& step) {
  std::optional<FilterState> state =
      initializer.add(step.stamp, step.reading.rate, step.reading.force);
  if (!state) return false;
  setInitialPose(*state);
  status.started_in_air = initializer.startedInAir();
  FilterState last;  // odom_T_base continues
  if (last_known) last.map_R_base = Eigen::Quaterniond(last_known->map_T_base.linear());
  odom.correct(last, *state);
  timeline.begin(*state, odom.odomTBase(*state));
  standstill.restart();
  gravity_stamp = step.stamp;
  publish();
  return true;
}

/// Sets the initial pose in the map: the one that was given, or the last known one.
void PoseFilter::State::setInitialPose(FilterState& state) {
  if (last_known) {
    state.position = last_known->map_T_base.translation();
    const double yaw = yawOf(Eigen::Quaterniond(last_known->map_T_base.linear()));
    state.map_R_base =
        Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())) * state.map_R_base;
  }
  if (initial_range && std::abs(initial_range->stamp - state.stamp) < kFreshHeight_s) {
    const double up = (state.map_R_base * Eigen::Vector3d::UnitZ()).z();
    state.position.z() = initial_range->value.x() * up;
    state.covariance(kPosition + 2, kPosition + 2) = initial_range->covariance(0, 0);
  }
  if (initial_pose) {
    initial_pose->stamp = state.stamp;
    apply(*initial_pose, config, state);
    initial_pose.reset();
  }
}

void PoseFilter::State::advance(const ImuStep& step) {
  const FilterState before = timeline.newest().state;
  FilterState predicted = before;
  moveEstimate(step.mean, step.dt, predicted);
  timeline.step(step.stamp, step.mean, step.dt > config.imu.silent_s);
  if (!checkHealth()) return;
  odom.advance(before, predicted, timeline.newest().state);
  timeline.newest().odom_T_base = odom.odomTBase(timeline.newest().state);
  publish();
  addOwnMeasurements(step);
}

/// Adds the measurements that are derived from the IMU: zero velocity and direction of gravity.
void PoseFilter::State::addOwnMeasurements(const ImuStep& step) {
  const std::optional<Eigen::Vector3d> mean =
      standstill.add(step.dt, step.reading.rate, step.reading.force);
  Measurement m;
  m.stamp = step.stamp;
  if (mean && config.motion.zero_velocity) {
    m.sensor = FilterSensor::kZeroVelocity;
    m.value = *mean;
    add(m, "");
  }
  if (timeline.empty() || !(config.motion.gravity_sigma > 0.0)) return;
  if (step.stamp - gravity_stamp < config.motion.gravity_period_s) return;
  const bool is_gravity =
      std::abs(step.mean.force.norm() - kGravity) <= config.motion.gravity_gate * kGravity;
  if (!is_gravity || step.mean.rate.norm() > kModerateRate) return;
  gravity_stamp = step.stamp;
  m.sensor = FilterSensor::kGravityDirection;
  m.value = step.mean.force;
  m.covariance = square(config.motion.gravity_sigma) * Eigen::Matrix3d::Identity();
  add(m, "");
}

bool PoseFilter::State::add(const Measurement& measurement, const std::string& fault) {
  SensorCounts& counts = countsOf(measurement.sensor);
  ++counts.received;
  std::string reason = fault;
  const bool running = !timeline.empty();
  const FilterState before = running ? timeline.newest().state : FilterState();
  if (reason.empty()) reason = timeline.insert(measurement);
  if (!reason.empty()) {
    ++counts.rejected[reason];
    return false;
  }
  if (running && measurement.stamp <= before.stamp && checkHealth()) {
    odom.correct(before, timeline.newest().state);
    publish();
  }
  return true;
}

void PoseFilter::State::judge(const Measurement& measurement, const Verdict& verdict) {
  SensorCounts& counts = countsOf(measurement.sensor);
  if (verdict.reason.empty()) {
    ++counts.accepted;
  } else {
    ++counts.rejected[verdict.reason];
  }
  if (!verdict.reinitialized) return;
  ++status.reinitializations;
  reinitializations.push_back(measurement.stamp);
  while (reinitializations.front() < measurement.stamp - config.gate.diverged_s)
    reinitializations.pop_front();
}

/// Returns true if the filter is healthy; otherwise resets it.
bool PoseFilter::State::checkHealth() {
  const FilterState& state = timeline.newest().state;
  if (!isHealthy(state)) {
    reset("not finite", false);
  } else if (state.gyro_bias.norm() > config.max_gyro_bias) {
    reset("gyro bias too large", true);
  } else if (state.accelerometer_bias.norm() > config.max_accelerometer_bias) {
    reset("accelerometer bias too large", true);
  } else if (reinitializations.size() >=
             static_cast<std::size_t>(config.gate.max_reinitializations)) {
    reset("diverged", true);
  }
  return !timeline.empty();
}

void PoseFilter::State::reset(const std::string& reason, bool biases_uncertain) {
  ++status.resets[reason];
  stop();
  if (biases_uncertain) {
    initializer.restartWithUncertainBiases();
  } else {
    initializer.restart();
  }
}

void PoseFilter::State::stop() {
  if (output) last_known = output;
  output.reset();
  timeline.clear();
  standstill.restart();
  reinitializations.clear();
  initial_range.reset();
}

void PoseFilter::State::publish() { output = outputOf(timeline.newest().state, reading); }

FilterOutput PoseFilter::State::outputOf(const FilterState& state,
                                         const InertialInput& input) const {
  FilterOutput out;
  out.stamp = state.stamp;
  out.map_T_base.linear() = state.map_R_base.toRotationMatrix();
  out.map_T_base.translation() = state.position;
  out.odom_T_base = odom.odomTBase(state);
  out.map_T_odom = odom.mapTOdom(state);
  out.velocity = state.velocity;
  out.angular_velocity = input.rate - state.gyro_bias;
  out.specific_force = input.force - state.accelerometer_bias;
  out.gyro_bias = state.gyro_bias;
  out.accelerometer_bias = state.accelerometer_bias;
  out.covariance = state.covariance.topLeftCorner<kFilterDim, kFilterDim>();
  separateMap(out.covariance);
  out.covariance(0, 0) += square(config.noise.mounting_sigma_rad);
  out.covariance(1, 1) += square(config.noise.mounting_sigma_rad);
  out.ground_m = state.ground;
  out.height_sigma_m = heightSigma(state);
  out.contradicted = state.rejected_since >= 0.0;
  return out;
}

FilterHealth PoseFilter::State::health(double now) const {
  if (imu.isBad() || !initializer.problem().empty()) return FilterHealth::kBadImu;
  if (!imu.newest() || now - *imu.newest() > config.imu.silent_s) return FilterHealth::kNoImu;
  if (timeline.empty()) return FilterHealth::kInitializing;
  const double aided = timeline.newest().state.aided_stamp;
  return now - aided > config.gate.coast_after_s ? FilterHealth::kCoasting : FilterHealth::kOk;
}

std::string PoseFilter::State::problem(FilterHealth health_now) const {
  switch (health_now) {
    case FilterHealth::kBadImu:
      return imu.isBad() ? imu.fault().message : initializer.problem();
    case FilterHealth::kNoImu:
      return imu.newest() ? "the IMU is silent" : "no IMU sample yet";
    case FilterHealth::kInitializing:
      return "collecting IMU samples for the initialization";
    case FilterHealth::kCoasting:
      return timeline.newest().state.partly_aided_stamp > timeline.newest().state.aided_stamp
                 ? "the laser does not see a direction (a corridor): the position drifts along it"
                 : "no pose or position was accepted recently: the position drifts";
    case FilterHealth::kOk:
      break;
  }
  if (!contradiction.empty()) return contradiction;
  if (imu.rate() >= config.imu.min_rate_hz || imu.rate() <= 0.0) return "";
  std::ostringstream text;
  text << "the rate of the IMU is " << imu.rate() << " Hz; at least " << config.imu.min_rate_hz
       << " Hz are needed for fast motion";
  return text.str();
}

}  // namespace kestrel
