// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_tracker.h"

namespace kestrel {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kG = 9.81;
constexpr double kPeriod = 0.01;

inline Quaterniond fromEuler(double roll, double pitch, double yaw) {
  return AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
         AngleAxisd(roll, Vector3d::UnitX());
}

/// A vehicle that rolls slightly from side to side while it turns.
inline Quaterniond trueAttitude(double time) {
  return fromEuler(0.1 * std::sin(time), 0.05, 0.2 * time);
}

inline ImuSample trueSample(double time, const Quaterniond& base_R_imu = Quaterniond::Identity()) {
  constexpr double kStep = 1e-4;
  const Quaterniond world_R_base = trueAttitude(time);
  const AngleAxisd turn(trueAttitude(time - kStep).conjugate() * trueAttitude(time + kStep));
  ImuSample sample;
  sample.stamp = time;
  sample.world_R_imu = world_R_base * base_R_imu;
  sample.angular_velocity = base_R_imu.conjugate() * (turn.angle() / (2.0 * kStep) * turn.axis());
  sample.linear_acceleration = sample.world_R_imu->conjugate() * Vector3d(0.0, 0.0, kG);
  return sample;
}

/// Feeds the readings of an IMU on a vehicle to a tracker.
class AttitudeTrackerTest : public ::testing::Test {
 protected:
  using Change = std::function<void(ImuSample&)>;

  /// Feeds readings for `duration` (s), each changed by `change`. Returns how many were used.
  int feed(
      double duration, const Change& change = [](ImuSample&) {}) {
    int used = 0;
    const auto steps = std::lround(duration / kPeriod);
    for (long i = 0; i < steps; ++i, time_ += kPeriod) {
      ImuSample sample = trueSample(time_, base_R_imu_);
      change(sample);
      used += tracker_.add(sample, base_R_imu_) ? 1 : 0;
    }
    return used;
  }

  ImuStatus status() const { return tracker_.status(time_); }

  void expect(ImuHealth health, const std::string& text) const {
    EXPECT_STREQ(toString(status().health), toString(health)) << status().message;
    EXPECT_NE(status().message.find(text), std::string::npos) << status().message;
  }

  /// Good readings must be used at once, and the health must be ok.
  void expectRecovery(double within = 0.05) {
    feed(within);
    expect(ImuHealth::kOk, "");
    EXPECT_EQ(feed(0.5), 50);
    expectAttitude(1e-6);
  }

  /// The newest attitude must be the true one.
  void expectAttitude(double tolerance_rad) const {
    const std::optional<double> latest = tracker_.buffer().latest();
    ASSERT_TRUE(latest);
    Attitude attitude;
    ASSERT_EQ(tracker_.buffer().lookup(*latest, attitude), AttitudeError::kNone);
    const Quaterniond expected = withoutYaw(trueAttitude(*latest));
    EXPECT_LT(attitude.stabilized_R_base.angularDistance(expected), tolerance_rad);
  }

  static void makeRaw(ImuSample& sample) { sample.world_R_imu.reset(); }

  double time_ = 1000.0;
  Quaterniond base_R_imu_ = Quaterniond::Identity();
  AttitudeTracker tracker_;
};

}  // namespace kestrel
