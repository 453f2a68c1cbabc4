// SPDX-License-Identifier: BSD-3-Clause
#include "mounting_monitor.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_estimator.h"

namespace kestrel {
namespace {

constexpr double kMaxWeight_s = 0.5;  // largest weight of one reading
constexpr double kTipped_s = 0.5;     // a flip takes less time
const double kLyingTilt = degToRad(60.0);
constexpr double kLying_s = 5.0;    // no vehicle flies at this tilt for so long
constexpr double kMean_s = 5.0;     // time constant of the means; accelerations average out
constexpr double kMinMean_s = 3.0;  // the means are used after this time
const double kMaxAngle = degToRad(30.0);
const double kUpsideDown = degToRad(150.0);
// Share of the force that must have a constant direction to be gravity.
constexpr double kMinShare = 0.5;
constexpr double kSizeTolerance = 0.2;

const char kAskMounting[] = "is the tf from the vehicle's base frame to the IMU's frame correct?";

std::string degrees(double angle) {
  return std::to_string(std::lround(radToDeg(angle))) + " degrees";
}

bool isNear(double size, double expected) {
  return std::abs(size - expected) <= kSizeTolerance * expected;
}

}  // namespace

std::string describeSize(double size) {
  constexpr double kOneG = 1.0, kMilliG = 1000.0;
  constexpr double kNothing = 0.8;  // less than 1 g in g
  std::ostringstream text;
  text.precision(3);
  text << size << " m/s² instead of " << kGravity;
  if (isNear(size, kOneG)) {
    text << ": it seems to be in g; sensor_msgs/Imu is in m/s²";
  } else if (isNear(size, kMilliG)) {
    text << ": it seems to be in thousandths of g; sensor_msgs/Imu is in m/s²";
  } else if (size < kNothing) {
    text << ": is it without gravity, or not filled in? sensor_msgs/Imu has +9.81 upwards at rest";
  } else {
    text << ": check its scale";
  }
  return text.str();
}

void MountingMonitor::add(double dt, const Eigen::Quaterniond& world_R_base,
                          const std::optional<Eigen::Vector3d>& force, bool estimated) {
  const double step = std::clamp(dt, 0.0, kMaxWeight_s);
  estimated_ = estimated;
  tilt_ = tiltOf(world_R_base);
  tipped_s_ = tilt_ > 0.5 * kPi ? tipped_s_ + step : 0.0;
  lying_s_ = tilt_ > kLyingTilt ? lying_s_ + step : 0.0;
  if (!force) return;
  const double gain = force_s_ > 0.0 ? step / std::min(force_s_ + step, kMean_s) : 1.0;
  mean_force_ += gain * (withoutYaw(world_R_base) * *force - mean_force_);
  mean_size_ += gain * (force->norm() - mean_size_);
  force_s_ += step;
}

MountingMonitor::Judgment MountingMonitor::judge() const {
  Judgment judgment = judgeTilt();
  if (judgment.message.empty()) judgment = judgeDirection();
  if (judgment.message.empty()) judgment = judgeSize();
  return judgment;
}

MountingMonitor::Judgment MountingMonitor::judgeTilt() const {
  const bool is_upside_down = tipped_s_ > kTipped_s;
  if (!is_upside_down && lying_s_ <= kLying_s) return {};
  std::string message = "according to the IMU the vehicle is " +
                        std::string(is_upside_down ? "upside down" : "lying on its side") +
                        " (tilted by " + degrees(tilt_) + "): " + kAskMounting;
  if (estimated_ && is_upside_down) {
    message += " Or does the accelerometer have the wrong sign? At rest it must read +9.8 upwards";
  }
  return {is_upside_down ? ImuHealth::kUpsideDown : ImuHealth::kContradiction, message};
}

MountingMonitor::Judgment MountingMonitor::judgeDirection() const {
  if (estimated_ || force_s_ < kMinMean_s) return {};
  if (!isNear(mean_size_, kGravity) && !isNear(mean_size_, 1.0)) return {};
  if (mean_force_.norm() < kMinShare * mean_size_) return {};
  const double angle = std::atan2(std::hypot(mean_force_.x(), mean_force_.y()), mean_force_.z());
  if (angle <= kMaxAngle) return {};
  std::string message = "the IMU's accelerometer and its orientation disagree by " +
                        degrees(angle) + " on the direction of gravity: ";
  message += angle >= kUpsideDown
                 ? "the accelerometer has the wrong sign (at rest it must read +9.8 "
                   "upwards), or the orientation's z axis points down"
                 : std::string(kAskMounting) +
                       " Are both given in that frame, with the world's z axis pointing up?";
  return {ImuHealth::kContradiction, message};
}

MountingMonitor::Judgment MountingMonitor::judgeSize() const {
  if (force_s_ < kMinMean_s) return {};
  const double size = estimated_ ? mean_force_.norm() : mean_size_;
  // The driver's own filter handles its accelerometer. A wrong unit is the only size error that is
  // reported.
  const double gate = estimated_ ? gravity_gate_ : 1.0 - kMinShare;
  if (std::abs(size - kGravity) <= gate * kGravity) return {};
  const std::string message = "the IMU's accelerometer reads " + describeSize(size);
  if (!estimated_) return {ImuHealth::kOk, message};
  return {ImuHealth::kContradiction, message + "; the attitude is not corrected by gravity"};
}

}  // namespace kestrel
