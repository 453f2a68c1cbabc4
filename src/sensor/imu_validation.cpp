// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/imu_validation.h"

#include <cmath>
#include <sstream>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kMaxNormError = 0.05;          // of a quaternion; smaller errors are rounding
constexpr double kMaxRate = 100.0;              // rad/s; three times the range of any gyro
const double kMaxDegrees = radToDeg(kMaxRate);  // the same in degrees per second
constexpr double kMaxAcceleration = 1e3;        // m/s², about 100 g
constexpr double kMaxStamp = 1e11;              // s, about 3000 years

std::string text(const Eigen::VectorXd& values) {
  std::ostringstream out;
  for (Eigen::Index i = 0; i < values.size(); ++i) out << (i > 0 ? ", " : "(") << values[i];
  out << ")";
  return out.str();
}

template <typename Value>
std::string text(const std::string& before, Value value, const std::string& after) {
  std::ostringstream out;
  out << before << value << after;
  return out.str();
}

std::optional<ImuFault> faultOf(const Eigen::Vector3d& value, double max, const std::string& what,
                                const std::string& unit, const std::string& reason) {
  if (!value.allFinite()) {
    return ImuFault{"not finite",
                    "the IMU's " + what + " is not finite: " + text(value) + "; check its driver"};
  }
  if (value.cwiseAbs().maxCoeff() <= max) return std::nullopt;
  return ImuFault{reason, "the IMU's " + what + " " + text(value) + " " + unit +
                              " is impossible; check its driver"};
}

bool areSame(const std::optional<Eigen::Vector3d>& a, const std::optional<Eigen::Vector3d>& b) {
  return a.has_value() == b.has_value() && (!a || *a == *b);
}

bool areSame(const ImuSample& a, const ImuSample& b) {
  const auto &q = a.world_R_imu, &p = b.world_R_imu;
  return q.has_value() == p.has_value() && (!q || q->coeffs() == p->coeffs()) &&
         areSame(a.angular_velocity, b.angular_velocity) &&
         areSame(a.linear_acceleration, b.linear_acceleration);
}

constexpr char kDegreesMessage[] =
    "the IMU's gyro turns 57 times more than the vehicle: it is in degrees per second and is "
    "converted; the driver must send rad/s";

}  // namespace

std::optional<ImuFault> faultOfStamp(double stamp) {
  if (std::abs(stamp) <= kMaxStamp) return std::nullopt;
  return ImuFault{"bad stamp", text("a stamp of ", stamp, " s is not valid; check the driver")};
}

std::optional<ImuFault> faultOf(const Eigen::Quaterniond& orientation, const std::string& whose) {
  const Eigen::Vector4d values = orientation.coeffs();
  if (!values.allFinite()) {
    return ImuFault{"not finite", whose + " is not finite: x y z w = " + text(values)};
  }
  const double norm = values.stableNorm();
  if (std::abs(norm - 1.0) <= kMaxNormError) return std::nullopt;
  return ImuFault{"bad quaternion", whose + " is not a rotation: x y z w = " + text(values) +
                                        text(" has the norm ", norm, " instead of 1")};
}

std::optional<ImuFault> faultOf(const ImuSample& sample) {
  std::optional<ImuFault> fault;
  if (sample.world_R_imu) {
    fault = faultOf(*sample.world_R_imu, "the IMU's orientation");
    if (fault) fault->message += "; check its driver, or set the attitude source to raw";
  }
  if (!fault && sample.angular_velocity) {
    fault =
        faultOf(*sample.angular_velocity, kMaxRate, "angular velocity", "rad/s", "impossible rate");
  }
  if (!fault && sample.linear_acceleration) {
    fault = faultOf(*sample.linear_acceleration, kMaxAcceleration, "acceleration", "m/s²",
                    "impossible acceleration");
  }
  return fault;
}

bool FrozenCheck::add(const ImuSample& sample) {
  // Readings without any value are no sign of a frozen sensor. They are refused for another reason.
  const bool empty = !sample.world_R_imu && !sample.angular_velocity && !sample.linear_acceleration;
  if (empty || !first_ || !areSame(*first_, sample) || sample.stamp < first_->stamp) {
    first_ = sample;
  }
  duration_s_ = sample.stamp - first_->stamp;
  return duration_s_ >= frozen_s_;
}

namespace {

std::optional<ImuFault> faultOfMounting(const Eigen::Isometry3d& base_T_imu) {
  const Eigen::Quaterniond rotation(base_T_imu.linear());
  if (auto fault = kestrel::faultOf(rotation, "the mounting of the IMU (tf)")) return fault;
  if (base_T_imu.translation().allFinite()) return std::nullopt;
  return ImuFault{"not finite",
                  "the mounting of the IMU (tf) has a translation that is not finite"};
}

/// Whether the values of a reading can be compared with each other. The gyro may be of any size,
/// because its unit is checked.
bool isComparable(const ImuSample& sample) {
  return !faultOfStamp(sample.stamp) && sample.world_R_imu && sample.angular_velocity &&
         sample.angular_velocity->allFinite() &&
         sample.angular_velocity->cwiseAbs().maxCoeff() <= kMaxDegrees &&
         !kestrel::faultOf(*sample.world_R_imu, "");
}

/// Whether the reading says nothing about the units. A rate that is impossible in rad/s may be one
/// in degrees per second.
bool isGarbage(const ImuSample& sample, const CheckedImu& checked) {
  if (sample.world_R_imu && sample.angular_velocity) return !isComparable(sample);
  return checked.fault.has_value();
}

/// A sentence about the gyro compared with the orientation; empty if both agree.
std::string gyroMessage(RotationVerdict verdict) {
  const std::string frame = ": are both given in the IMU's frame, x forward, y left, z up?";
  switch (verdict) {
    case RotationVerdict::kDegrees:
      return kDegreesMessage;
    case RotationVerdict::kFirstZero:
      return "the IMU's gyro reads zero although its orientation turns: the gyro is not used; "
             "check its driver";
    case RotationVerdict::kSecondZero:
      return "the IMU's orientation stands still although its gyro turns: gyro and accelerometer "
             "are used instead; the driver must set orientation_covariance[0] to -1";
    case RotationVerdict::kOpposite:
      return "the IMU's gyro and orientation turn in opposite directions" + frame;
    case RotationVerdict::kDifferent:
      return "the IMU's gyro and orientation turn about different axes" + frame;
    default:
      return "";
  }
}

const char* reasonOf(RotationVerdict verdict) {
  switch (verdict) {
    case RotationVerdict::kDegrees:
      return "gyro in degrees";
    case RotationVerdict::kFirstZero:
      return "gyro is zero";
    case RotationVerdict::kSecondZero:
      return "orientation stands still";
    default:
      return "gyro contradicts orientation";
  }
}

}  // namespace

/// Converts or removes values that contradict the others. A few readings pass before the reason is
/// known; a gyro in doubt is not used until then, because the orientation gives the yaw too.
void ImuCheck::removeContradictions(CheckedImu& checked) {
  ImuSample& sample = checked.sample;
  const bool complete = sample.angular_velocity && sample.linear_acceleration;
  const RotationVerdict verdict = told_degrees_ ? RotationVerdict::kDegrees : gyro_.verdict();
  const std::string message = gyroMessage(verdict);
  if (!message.empty()) checked.contradiction = ImuFault{reasonOf(verdict), message};
  if (verdict == RotationVerdict::kDegrees) {
    checked.converted = true;
    if (sample.angular_velocity) *sample.angular_velocity *= degToRad(1.0);
  } else if (verdict == RotationVerdict::kFirstZero) {
    sample.angular_velocity.reset();
  } else if (verdict == RotationVerdict::kSecondZero && complete) {
    checked.orientation_fault = checked.contradiction;
    sample.world_R_imu.reset();
  } else if (gyro_.doubts() && sample.world_R_imu && !faultOf(checked.sample)) {
    sample.angular_velocity.reset();
  }
}

CheckedImu ImuCheck::check(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) {
  CheckedImu checked;
  checked.sample = sample;
  checked.base_T_imu = base_T_imu;
  if (isComparable(sample)) gyro_.add(sample);
  removeContradictions(checked);
  ImuSample orientation, raw = checked.sample;
  orientation.world_R_imu = checked.sample.world_R_imu;
  raw.world_R_imu.reset();
  if (!checked.orientation_fault) checked.orientation_fault = faultOf(orientation);
  checked.fault = faultOfStamp(sample.stamp);
  if (!checked.fault) checked.fault = faultOf(raw);
  if (!checked.fault) checked.fault = faultOfMounting(base_T_imu);
  if (isGarbage(sample, checked)) gyro_.interrupt();
  if (checked.fault) return checked;
  checked.order = stamps_.check(sample.stamp);
  checked.jump_s = stamps_.jump();
  if (checked.order != StampCheck::Verdict::kLate) frozen_.add(sample);
  checked.frozen_s = frozen_.duration();
  return checked;
}

}  // namespace kestrel
