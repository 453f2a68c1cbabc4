// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/filter/pose_filter.h"

#include <algorithm>

#include "intake_checks.h"
#include "pose_filter_state.h"

namespace kestrel {
namespace {

constexpr double kExtrapolation_s = 0.1;  // maximum extrapolation of the last reading
constexpr double kMaxBarometer = 1e5;     // m

Eigen::Matrix3d variance(double sigma) { return sigma * sigma * Eigen::Matrix3d::Identity(); }

}  // namespace

PoseFilter::PoseFilter(const PoseFilterConfig& config) {
  validate(config);
  state_ = std::make_unique<State>(config);
}
PoseFilter::~PoseFilter() = default;
PoseFilter::PoseFilter(PoseFilter&&) noexcept = default;
PoseFilter& PoseFilter::operator=(PoseFilter&&) noexcept = default;

bool PoseFilter::addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) {
  return state_->addImu(state_->imu_check.check(sample, base_T_imu));
}

bool PoseFilter::addImu(const CheckedImu& reading) { return state_->addImu(reading); }

bool PoseFilter::addPose(const PoseMeasurement& measurement) {
  Measurement m;
  m.sensor = FilterSensor::kPose;
  m.stamp = measurement.stamp;
  m.value = {measurement.pose.x, measurement.pose.y, measurement.pose.yaw};
  m.covariance = measurement.covariance;
  m.unobservable = measurement.unobservable;
  return state_->add(m, faultOf(measurement));
}

bool PoseFilter::addPosition(const PositionMeasurement& measurement) {
  Measurement m;
  m.sensor = FilterSensor::kPosition;
  m.stamp = measurement.stamp;
  m.value = measurement.position;
  m.covariance = measurement.covariance;
  return state_->add(m, faultOf(measurement));
}

bool PoseFilter::addYaw(const YawMeasurement& measurement) {
  Measurement m;
  m.sensor = FilterSensor::kYaw;
  m.stamp = measurement.stamp;
  m.value.x() = measurement.yaw;
  m.covariance = variance(std::max(measurement.sigma, config().yaw_sigma_rad));
  return state_->add(m, faultOf(measurement));
}

bool PoseFilter::addRange(const HeightSample& sample) {
  Measurement m;
  m.sensor = FilterSensor::kRange;
  m.stamp = sample.stamp;
  m.value.x() = sample.height_m;
  m.covariance = variance(config().height.range_sigma_m);
  const std::string fault = faultOf(sample, true, config().height.range_max_m);
  if (fault.empty() && state_->timeline.empty()) state_->initial_range = m;
  return state_->add(m, fault);
}

bool PoseFilter::addFloorHeight(const HeightSample& sample) {
  Measurement m;
  m.sensor = FilterSensor::kFloorBeams;
  m.stamp = sample.stamp;
  m.value.x() = sample.height_m;
  m.covariance = variance(config().height.floor_beam_sigma_m);
  return state_->add(m, faultOf(sample, true, config().height.range_max_m));
}

bool PoseFilter::addBarometer(const HeightSample& sample) {
  Measurement m;
  m.sensor = FilterSensor::kBarometer;
  m.stamp = sample.stamp;
  m.value.x() = sample.height_m;
  m.covariance = variance(config().height.barometer_sigma_m);
  return state_->add(m, faultOf(sample, false, kMaxBarometer));
}

const std::optional<FilterOutput>& PoseFilter::output() const { return state_->output; }

std::optional<FilterOutput> PoseFilter::at(double time) const {
  const State& s = *state_;
  if (s.timeline.empty() || !(time <= s.timeline.newest().state.stamp + kExtrapolation_s)) {
    return std::nullopt;
  }
  const Timeline::Node* node = s.timeline.lastNotAfter(time);
  if (node == nullptr) return std::nullopt;
  const Timeline::Node* next = s.timeline.after(*node);
  const InertialInput input = next != nullptr ? next->input : s.reading;
  FilterState moved = node->state;
  moveEstimate(input, time - moved.stamp, moved);
  moved.stamp = time;
  FilterOutput result = s.outputOf(moved, input);
  const Eigen::Isometry3d before =
      Eigen::Translation3d(node->state.position) * node->state.map_R_base;
  result.odom_T_base = node->odom_T_base * before.inverse() * result.map_T_base;
  return result;
}

bool PoseFilter::setPose(const Pose2& map_T_base, const Eigen::Matrix3d& covariance) {
  if (!map_T_base.isFinite() || !isCovariance(covariance)) return false;
  Measurement m;
  m.sensor = FilterSensor::kPose;
  m.value = {map_T_base.x, map_T_base.y, map_T_base.yaw};
  m.covariance = covariance;
  m.bypass_gate = true;
  if (state_->timeline.empty()) {
    state_->initial_pose = m;
    return true;
  }
  m.stamp = state_->timeline.newest().state.stamp;
  return state_->add(m, "");
}

void PoseFilter::restart() { state_->reset("on request", false); }

FilterStatus PoseFilter::status(double now) const {
  FilterStatus status = state_->status;
  status.health = state_->health(now);
  status.message = state_->problem(status.health);
  status.imu_rate_hz = state_->imu.rate();
  return status;
}

double PoseFilter::imuRate() const { return state_->imu.rate(); }

const PoseFilterConfig& PoseFilter::config() const { return state_->config; }

}  // namespace kestrel
