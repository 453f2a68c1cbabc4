// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/attitude_tracker.h"

#include <cmath>
#include <sstream>

#include "kestrel_slam/sensor/attitude_estimator.h"
#include "kestrel_slam/sensor/imu_validation.h"
#include "kestrel_slam/sensor/stamp_check.h"
#include "mounting_monitor.h"

namespace kestrel {
namespace {

// The IMU is invalid after this many unusable readings in a row. A single one does not matter.
constexpr int kInvalidAfter = 3;

std::string seconds(double duration_s) {
  std::ostringstream text;
  text.precision(3);
  text << duration_s << " s";
  return text.str();
}

}  // namespace

const char* toString(ImuHealth health) {
  switch (health) {
    case ImuHealth::kOk:
      return "ok";
    case ImuHealth::kNoData:
      return "no-data";
    case ImuHealth::kSilent:
      return "silent";
    case ImuHealth::kFrozen:
      return "frozen";
    case ImuHealth::kInvalid:
      return "invalid";
    case ImuHealth::kUpsideDown:
      return "upside-down";
    case ImuHealth::kContradiction:
      return "contradiction";
  }
  return "unknown";
}

struct AttitudeTracker::State {
  explicit State(const AttitudeConfig& c)
      : config(c), buffer(c.buffer), estimator(c), monitor(c.gravity_gate) {}

  std::optional<ImuFault> addReading(const CheckedImu& reading);
  std::optional<ImuFault> addAttitude(double stamp, const Eigen::Quaterniond& world_R_base);
  std::optional<ImuFault> judgeOrder(StampCheck::Verdict order, double jump_s);
  std::optional<ImuFault> useOrientation(const ImuSample& sample,
                                         const Eigen::Quaterniond& base_R_imu);
  std::optional<ImuFault> useRaw(const ImuSample& sample, const Eigen::Quaterniond& base_R_imu);
  std::optional<ImuFault> put(double stamp, const Eigen::Quaterniond& world_R_base,
                              const std::optional<Eigen::Vector3d>& rate,
                              const std::optional<Eigen::Vector3d>& force);
  bool count(double stamp, const std::optional<ImuFault>& result);
  void forget();

  AttitudeConfig config;
  AttitudeBuffer buffer;
  AttitudeEstimator estimator;
  StampCheck stamp_check;
  ImuCheck imu_check;
  MountingMonitor monitor;

  ImuStatus status;  ///< only the counters are kept up to date
  std::optional<double> last_received;
  bool frozen = false;
  bool is_late = false;  ///< of the reading that is being added
  int rejected_in_a_row = 0;
  std::string last_fault;
  std::optional<ImuFault> contradiction;  ///< of the values of the last reading
  bool converted = false;                 ///< the gyro of the last reading was converted
};

AttitudeTracker::AttitudeTracker(const AttitudeConfig& config)
    : state_(std::make_unique<State>(config)) {}
AttitudeTracker::~AttitudeTracker() = default;
AttitudeTracker::AttitudeTracker(AttitudeTracker&&) noexcept = default;
AttitudeTracker& AttitudeTracker::operator=(AttitudeTracker&&) noexcept = default;

const AttitudeBuffer& AttitudeTracker::buffer() const { return state_->buffer; }

bool AttitudeTracker::add(const ImuSample& sample, const Eigen::Quaterniond& base_R_imu) {
  const auto fault = faultOf(base_R_imu, "the mounting of the IMU (tf)");
  const Eigen::Quaterniond mounting = fault ? Eigen::Quaterniond::Identity() : base_R_imu;
  CheckedImu reading = state_->imu_check.check(sample, Eigen::Isometry3d(mounting.normalized()));
  if (!reading.fault) reading.fault = fault;
  return add(reading);
}

bool AttitudeTracker::add(const CheckedImu& reading) {
  return state_->count(reading.sample.stamp, state_->addReading(reading));
}

bool AttitudeTracker::addAttitude(double stamp, const Eigen::Quaterniond& world_R_base) {
  return state_->count(stamp, state_->addAttitude(stamp, world_R_base));
}

void AttitudeTracker::restart() {
  state_->forget();
  state_->stamp_check.restart();
  state_->imu_check.restart();
}

void AttitudeTracker::State::forget() {
  buffer.clear();
  estimator.restart();
  monitor.restart();
  frozen = false;
}

bool AttitudeTracker::State::count(double stamp, const std::optional<ImuFault>& result) {
  ++status.received;
  if (std::isfinite(stamp)) last_received = stamp;
  if (result) {
    ++status.rejected[result->reason];
    ++rejected_in_a_row;
    last_fault = result->message;
    return false;
  }
  ++status.used;
  rejected_in_a_row = 0;
  return true;
}

std::optional<ImuFault> AttitudeTracker::State::judgeOrder(StampCheck::Verdict order,
                                                           double jump_s) {
  is_late = order == StampCheck::Verdict::kLate;
  if (order == StampCheck::Verdict::kSetBack) forget();
  if (order != StampCheck::Verdict::kJump) return std::nullopt;
  return ImuFault{"stamp jumps",
                  "the stamp jumps by " + seconds(jump_s) +
                      "; stamps after the jump are used once several in a row agree"};
}

std::optional<ImuFault> AttitudeTracker::State::addReading(const CheckedImu& reading) {
  contradiction = reading.contradiction;
  if (reading.converted != converted) estimator = AttitudeEstimator(config);  // its bias is wrong
  converted = reading.converted;
  if (reading.fault) return reading.fault;
  if (const auto fault = judgeOrder(reading.order, reading.jump_s)) return fault;
  if (!is_late) frozen = reading.frozen_s >= config.frozen_s;
  if (frozen) {
    return ImuFault{"frozen", "the IMU has sent the same reading for " + seconds(reading.frozen_s) +
                                  "; restart the IMU or its driver"};
  }
  const ImuSample& sample = reading.sample;
  const Eigen::Quaterniond mounting = Eigen::Quaterniond(reading.base_T_imu.linear()).normalized();
  const bool takes_orientation =
      config.source == "orientation" || (config.source != "raw" && sample.world_R_imu);
  if (!takes_orientation) return useRaw(sample, mounting);
  if (reading.orientation_fault) return reading.orientation_fault;
  return useOrientation(sample, mounting);
}

std::optional<ImuFault> AttitudeTracker::State::addAttitude(
    double stamp, const Eigen::Quaterniond& world_R_base) {
  if (const auto fault = faultOfStamp(stamp)) return fault;
  if (const auto fault = faultOf(world_R_base, "the attitude")) return fault;
  const StampCheck::Verdict order = stamp_check.check(stamp);
  if (const auto fault = judgeOrder(order, stamp_check.jump())) return fault;
  status.estimated = false;
  return put(stamp, world_R_base.normalized(), std::nullopt, std::nullopt);
}

std::optional<ImuFault> AttitudeTracker::State::useOrientation(
    const ImuSample& sample, const Eigen::Quaterniond& base_R_imu) {
  if (!sample.world_R_imu) {
    return ImuFault{"no orientation",
                    "the IMU gives no orientation (its covariance begins with "
                    "-1); set the attitude source to auto or raw"};
  }
  const auto toBase = [&](const std::optional<Eigen::Vector3d>& in_imu) {
    return in_imu ? std::make_optional<Eigen::Vector3d>(base_R_imu * *in_imu) : std::nullopt;
  };
  status.estimated = false;
  const Eigen::Quaterniond world_R_base = sample.world_R_imu->normalized() * base_R_imu.conjugate();
  return put(sample.stamp, world_R_base, toBase(sample.angular_velocity),
             toBase(sample.linear_acceleration));
}

std::optional<ImuFault> AttitudeTracker::State::useRaw(const ImuSample& sample,
                                                       const Eigen::Quaterniond& base_R_imu) {
  if (!sample.angular_velocity) {
    return ImuFault{"no gyro", "the IMU gives neither an orientation nor an angular velocity"};
  }
  if (!sample.linear_acceleration) {
    return ImuFault{"no accelerometer", "the IMU gives neither an orientation nor an acceleration"};
  }
  if (is_late) return ImuFault{"late", "a gyro reading arrived twice or after newer ones"};
  status.estimated = true;
  const Eigen::Vector3d force = base_R_imu * *sample.linear_acceleration;
  for (const EstimatedAttitude& attitude :
       estimator.add(sample.stamp, base_R_imu * *sample.angular_velocity, force)) {
    put(attitude.stamp, attitude.world_R_base, attitude.rate, force);
  }
  if (const std::optional<double> refused = estimator.refusedGravity()) {
    return ImuFault{"no gravity", "the IMU's accelerometer reads " + describeSize(*refused)};
  }
  return std::nullopt;
}

std::optional<ImuFault> AttitudeTracker::State::put(double stamp,
                                                    const Eigen::Quaterniond& world_R_base,
                                                    const std::optional<Eigen::Vector3d>& rate,
                                                    const std::optional<Eigen::Vector3d>& force) {
  const std::optional<double> before = buffer.latest();
  if (!buffer.add(stamp, world_R_base, rate, force)) {
    return ImuFault{"duplicate", "two readings have the same stamp"};
  }
  if (!is_late) monitor.add(before ? stamp - *before : 0.0, world_R_base, force, status.estimated);
  return std::nullopt;
}

ImuStatus AttitudeTracker::status(double now) const {
  const State& state = *state_;
  ImuStatus status = state.status;
  if (status.received == 0) {
    status.health = ImuHealth::kNoData;
    status.message = "no reading of the IMU yet";
  } else if (state.last_received && now - *state.last_received > state.config.silent_s) {
    status.health = ImuHealth::kSilent;
    status.message = "no reading of the IMU for " + seconds(now - *state.last_received) +
                     ": is its driver running?";
  } else if (state.frozen) {
    status.health = ImuHealth::kFrozen;
    status.message = state.last_fault;
  } else if (state.rejected_in_a_row >= kInvalidAfter || status.used == 0) {
    status.health = ImuHealth::kInvalid;
    status.message = state.last_fault;
  } else {
    status.health = state.monitor.health();
    status.message = state.monitor.message();
    if (status.message.empty() && state.contradiction) {
      status.health = state.converted ? ImuHealth::kOk : ImuHealth::kContradiction;
      status.message = state.contradiction->message;
      status.reason = state.contradiction->reason;
    }
  }
  if (status.reason.empty()) status.reason = toString(status.health);
  return status;
}

}  // namespace kestrel
