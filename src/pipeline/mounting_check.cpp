// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/mounting_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/scan_turn.h"

namespace kestrel {
namespace {

constexpr double kPeriod = 0.2;    // s; between two scans that are compared
constexpr double kMaxPause = 1.0;  // s
constexpr double kKept_s = 10.0;   // s
constexpr std::size_t kMostLasers = 16;
constexpr double kMostTilted = 0.5;  // cosine; a laser that is tilted further shows no yaw
const double kMaxTilt = degToRad(3.0);

std::string text(double value, int decimals) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*f", decimals, value);
  return buffer;
}

std::vector<ImuFault> problemsOfGyro(const TurnCheck& gyro) {
  std::vector<ImuFault> problems;
  if (gyro.verdict() == RotationVerdict::kOpposite) {
    problems.push_back({"gyro opposite to scan",
                        "gyro and scan turn in opposite directions; the gyro's yaw is not used. Is "
                        "the laser or the IMU upside down, unlike in tf? Or is the IMU "
                        "forward-right-down?"});
  } else if (gyro.verdict() == RotationVerdict::kFirstZero) {
    problems.push_back({"gyro does not turn",
                        "the scans turn but the gyro does not; its yaw is not used. Check the IMU "
                        "and its mounting in tf"});
  }
  if (gyro.delay()) {
    problems.push_back(
        {"clock of the IMU", "the IMU's stamps are about " + text(std::abs(*gyro.delay()), 2) +
                                 " s " + (*gyro.delay() > 0.0 ? "later" : "earlier") +
                                 " than those of the laser: both drivers must use the same clock"});
  }
  return problems;
}

}  // namespace

void MountingCheck::addMounting(const std::string& source, const Eigen::Isometry3d& base_T_laser) {
  const Eigen::Vector3d axis = base_T_laser.linear().col(2);
  const auto known = first_axes_.find(source);
  if (known == first_axes_.end()) {
    if (first_axes_.size() < kMostLasers) first_axes_.emplace(source, axis);
    return;
  }
  const double tilt = std::acos(std::clamp(axis.dot(known->second), -1.0, 1.0));
  tilt_rad_ = std::max(tilt_rad_, tilt);
}

bool MountingCheck::isDue(const std::string& source, double time) const {
  const auto laser = lasers_.find(source);
  if (laser == lasers_.end()) return lasers_.size() < kMostLasers;
  return std::abs(time - laser->second.time) >= kPeriod;
}

void MountingCheck::addScan(const std::string& source, double time, std::vector<float> ranges,
                            const Eigen::Isometry3d& base_T_laser) {
  const Eigen::Vector3d axis = base_T_laser.linear().col(2);
  const auto [place, is_new] = lasers_.try_emplace(source);
  Laser& laser = place->second;
  const double seconds = time - laser.time;
  if (!is_new && seconds > 0.0 && seconds < kMaxPause && std::abs(axis.z()) > kMostTilted) {
    if (const std::optional<double> turn = turnBetween(laser.ranges, ranges)) {
      const double vehicle_turn = axis.z() > 0.0 ? *turn : -*turn;
      gyro_.add(laser.time, time, vehicle_turn);
      odometry_.add(laser.time, time, vehicle_turn);
    }
  }
  laser.time = time;
  laser.ranges = std::move(ranges);
}

void MountingCheck::addOdometry(double time, double yaw) {
  if (!odometry_yaws_.empty() && time <= odometry_yaws_.back().time) return;
  if (!odometry_yaws_.empty()) {
    yaw = odometry_yaws_.back().yaw + normalizeAngle(yaw - odometry_yaws_.back().yaw);
  }
  odometry_yaws_.push_back({time, yaw});
  while (odometry_yaws_.front().time < time - kKept_s) odometry_yaws_.pop_front();
  odometry_.compare(time, [this](double t) { return odometryAt(t); });
}

std::optional<double> MountingCheck::odometryAt(double time) const {
  const auto after = std::lower_bound(odometry_yaws_.begin(), odometry_yaws_.end(), time,
                                      [](const Yaw& yaw, double t) { return yaw.time < t; });
  if (after == odometry_yaws_.begin() || after == odometry_yaws_.end()) return std::nullopt;
  const Yaw &a = *(after - 1), &b = *after;
  if (b.time - a.time > kMaxPause) return std::nullopt;
  return a.yaw + (time - a.time) / (b.time - a.time) * (b.yaw - a.yaw);
}

void MountingCheck::compareGyro(const AttitudeBuffer& attitude) {
  const std::optional<double> latest = attitude.latest();
  if (!latest) return;
  gyro_.compare(*latest, [&attitude](double time) -> std::optional<double> {
    Attitude at;
    if (attitude.lookup(time, at) != AttitudeError::kNone) return std::nullopt;
    return at.integrated_yaw;
  });
}

bool MountingCheck::gyroMisleads() const {
  return gyro_.verdict() == RotationVerdict::kOpposite ||
         gyro_.verdict() == RotationVerdict::kFirstZero;
}

std::vector<ImuFault> MountingCheck::problems() const {
  std::vector<ImuFault> problems = problemsOfGyro(gyro_);
  if (odometry_.verdict() == RotationVerdict::kOpposite) {
    problems.push_back({"odometry opposite to scan",
                        "odometry and scan turn in opposite directions: is the laser upside down, "
                        "unlike in tf, or are its ranges in reverse order?"});
  }
  return problems;
}

std::vector<ImuFault> MountingCheck::problemsOfLevelLaser() const {
  if (tilt_rad_ < kMaxTilt) return {};
  return {{"laser tilts",
           "according to tf the laser tilts, by " + text(radToDeg(tilt_rad_), 0) +
               " degrees so far, but it is assumed to be level: use mav.launch, with an IMU, "
               "instead of mapper.launch"}};
}

}  // namespace kestrel
