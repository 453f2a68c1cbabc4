// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/attitude_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/random.h"
#include "sensor/tracked_imu.h"

namespace kestrel {
namespace {

/// A known motion and an IMU that measures it.
struct KnownMotion {
  std::function<Quaterniond(double)> world_R_base = [](double) { return Quaterniond::Identity(); };
  std::function<Vector3d(double)> acceleration = [](double) { return Vector3d(0.0, 0.0, 0.0); };
  Vector3d gyro_bias = Vector3d::Zero();
  double gyro_noise = 0.0;   // rad/s, of each reading
  double force_noise = 0.0;  // m/s²

  Vector3d rate(double t) const {
    constexpr double kStep = 1e-4;
    const AngleAxisd turn(world_R_base(t - kStep).conjugate() * world_R_base(t + kStep));
    return turn.angle() / (2.0 * kStep) * turn.axis();
  }
  Vector3d force(double t) const {
    return world_R_base(t).conjugate() * (acceleration(t) + Vector3d(0.0, 0.0, kGravity));
  }
};

/// Angle between the true and the estimated vertical, rad.
double tiltError(const KnownMotion& motion, const EstimatedAttitude& attitude) {
  const Vector3d up = Vector3d::UnitZ();
  const Vector3d actual = motion.world_R_base(attitude.stamp).conjugate() * up;
  const Vector3d estimated = attitude.world_R_base.conjugate() * up;
  return std::atan2(actual.cross(estimated).norm(), actual.dot(estimated));
}

/// Feeds the readings of a motion to an estimator.
class EstimatedMotion {
 public:
  explicit EstimatedMotion(KnownMotion motion, const AttitudeConfig& config = AttitudeConfig())
      : motion_(std::move(motion)), estimator_(config) {}

  /// Runs until `until` (s). Returns the largest error of roll and pitch, rad.
  double fly(double until, double rate_hz = 100.0) {
    double worst = 0.0;
    for (; time_ < until; time_ += 1.0 / rate_hz) {
      const Vector3d rate = motion_.rate(time_) + motion_.gyro_bias + noise(motion_.gyro_noise);
      for (const EstimatedAttitude& a :
           estimator_.add(time_, rate, motion_.force(time_) + noise(motion_.force_noise))) {
        EXPECT_TRUE(a.world_R_base.coeffs().allFinite());
        worst = std::max(worst, tiltError(motion_, a));
        ++attitudes_;
        last_ = a;
      }
    }
    return worst;
  }

  void skip(double duration) { time_ += duration; }
  int attitudes() const { return attitudes_; }
  const EstimatedAttitude& last() const { return last_; }
  AttitudeEstimator& estimator() { return estimator_; }

 private:
  Vector3d noise(double sigma) {
    return {sigma * random_.gaussian(), sigma * random_.gaussian(), sigma * random_.gaussian()};
  }

  KnownMotion motion_;
  AttitudeEstimator estimator_;
  Random random_{1};
  double time_ = 0.0;
  int attitudes_ = 0;
  EstimatedAttitude last_;
};

KnownMotion swinging(double amplitude, double frequency_rad_s) {
  KnownMotion motion;
  motion.world_R_base = [=](double t) {
    return fromEuler(amplitude * std::sin(frequency_rad_s * t),
                     amplitude * std::cos(0.7 * frequency_rad_s * t), 0.3 * t);
  };
  return motion;
}

/// From 10 s on the vehicle accelerates with `size` (m/s²) for `duration` (s), and brakes for the
/// same time if `brakes`. It tilts within 0.3 s so that the thrust stays along the z axis of the
/// body.
KnownMotion accelerating(double size, double duration, bool brakes) {
  const auto acceleration = [=](double t) {
    const auto pulse = [=](double from) {
      constexpr double kRamp = 0.3;
      const double s = std::clamp((t - from) / kRamp, 0.0, 1.0) -
                       std::clamp((t - from - duration) / kRamp, 0.0, 1.0);
      return 0.5 * size * (1.0 - std::cos(kPi * s));
    };
    const double brake = brakes ? pulse(10.0 + duration + 1.0) : 0.0;
    return Vector3d(pulse(10.0) - brake, 0.0, 0.0);
  };
  KnownMotion motion;
  motion.acceleration = acceleration;
  motion.world_R_base = [=](double t) {
    return fromEuler(0.0, std::atan2(acceleration(t).x(), kGravity), 0.0);
  };
  return motion;
}

TEST(AttitudeEstimator, FindsAConstantTiltAtOnceAndKeepsIt) {
  for (const Quaterniond& tilt : {fromEuler(0.3, -0.2, 1.0), fromEuler(kPi, 0.0, 0.0),
                                  fromEuler(0.0, 0.5 * kPi, 0.0), fromEuler(2.5, 0.4, -2.0)}) {
    KnownMotion motion;
    motion.world_R_base = [=](double) { return tilt; };
    EstimatedMotion observed(motion);
    EXPECT_LT(observed.fly(20.0), 1e-7);
    EXPECT_EQ(observed.attitudes(), 2000) << "all collected attitudes must be returned";
  }
}

TEST(AttitudeEstimator, IntegratesASpinExactly) {
  KnownMotion motion;
  motion.world_R_base = [](double t) {
    return fromEuler(0.0, 0.0, 2.0 * t) * fromEuler(0.1, 0.2, 0.0);
  };
  for (const double rate_hz : {10.0, 100.0, 2000.0}) {
    EstimatedMotion observed(motion);
    EXPECT_LT(observed.fly(20.0, rate_hz), 1e-6) << rate_hz << " Hz";
    const double turned = yawOf(observed.last().world_R_base) - 2.0 * observed.last().stamp;
    EstimatedMotion again(motion);
    again.fly(0.4, rate_hz);
    const double start = yawOf(again.last().world_R_base) - 2.0 * again.last().stamp;
    EXPECT_NEAR(normalizeAngle(turned - start), 0.0, 1e-5) << rate_hz << " Hz";
  }
}

TEST(AttitudeEstimator, FollowsSwingsAtAnyRate) {
  const KnownMotion motion = swinging(degToRad(20.0), 3.0);
  EXPECT_LT(radToDeg(EstimatedMotion(motion).fly(60.0, 2000.0)), 0.02);
  EXPECT_LT(radToDeg(EstimatedMotion(motion).fly(60.0, 200.0)), 0.02);
  EXPECT_LT(radToDeg(EstimatedMotion(motion).fly(60.0, 50.0)), 0.05);
  EXPECT_LT(radToDeg(EstimatedMotion(motion).fly(60.0, 10.0)), 1.0);
}

TEST(AttitudeEstimator, TwoSecondsOfAccelerationCauseLittleError) {
  for (const bool brakes : {false, true}) {
    EstimatedMotion observed(accelerating(2.0, 2.0, brakes));
    EXPECT_LT(observed.fly(9.9), 1e-7);
    const double worst = radToDeg(observed.fly(30.0));
    EXPECT_LT(worst, 1.5);
    EXPECT_GT(worst, 0.1) << "the motion must cause some error";
    observed.fly(40.0);
    EXPECT_LT(radToDeg(observed.fly(60.0)), 0.1) << "the error must decay";
    RecordProperty(brakes ? "degrees_with_braking" : "degrees", std::to_string(worst));
  }
}

TEST(AttitudeEstimator, AMinuteOfCirclingCausesLittleError) {
  KnownMotion motion;  // 2 m/s at a radius of 2 m, nose ahead, reached within 5 s from rest
  const auto rate = [](double t) { return t < 10.0 ? 0.0 : std::min((t - 10.0) / 5.0, 1.0); };
  const auto angle = [](double t) {
    if (t < 10.0) return 0.0;
    return t < 15.0 ? 0.1 * (t - 10.0) * (t - 10.0) : t - 12.5;
  };
  motion.acceleration = [=](double t) {
    const double radial = 2.0 * rate(t) * rate(t);
    return Vector3d(-radial * std::sin(angle(t)), radial * std::cos(angle(t)), 0.0);
  };
  motion.world_R_base = [=](double t) {
    return fromEuler(0.0, 0.0, angle(t)) *
           fromEuler(-std::atan2(2.0 * rate(t) * rate(t), kGravity), 0.0, 0.0);
  };
  EstimatedMotion observed(motion);
  EXPECT_LT(radToDeg(observed.fly(70.0)), 2.0);
}

TEST(AttitudeEstimator, CorrectsAnInitializationDuringAcceleration) {
  KnownMotion motion;
  motion.acceleration = [](double t) { return Vector3d(t < 1.0 ? 1.5 : 0.0, 0.0, 0.0); };
  EstimatedMotion observed(motion);
  EXPECT_NEAR(radToDeg(observed.fly(0.5)), radToDeg(std::atan(1.5 / kGravity)), 0.5);
  observed.fly(6.0);
  EXPECT_LT(radToDeg(observed.fly(15.0)), 3.0);
  EXPECT_LT(radToDeg(observed.fly(30.0)), 0.5);
}

TEST(AttitudeEstimator, LearnsTheBiasAtAStandstill) {
  KnownMotion motion;
  motion.gyro_bias = {0.02, -0.015, 0.01};
  motion.gyro_noise = 0.005;
  motion.force_noise = 0.05;
  EstimatedMotion observed(motion);
  EXPECT_LT(radToDeg(observed.fly(10.0)), 1.0);
  EXPECT_LT((observed.estimator().gyroBias() - motion.gyro_bias).norm(), 0.001);
  EXPECT_LT(observed.last().rate.norm(), 0.03) << "only noise remains";
}

TEST(AttitudeEstimator, LearnsTheBiasOfRollAndPitchInFlight) {
  KnownMotion motion = swinging(0.1, 2.0);
  motion.gyro_bias = {0.02, -0.02, 0.0};
  EstimatedMotion observed(motion);
  EXPECT_LT(radToDeg(observed.fly(30.0)), 6.0);
  observed.fly(300.0);
  EXPECT_LT((observed.estimator().gyroBias() - motion.gyro_bias).head<2>().norm(), 0.007);
  EXPECT_LT(radToDeg(observed.fly(330.0)), 1.0);
}

TEST(AttitudeEstimator, ASteadyTurnIsNotTakenForBias) {
  KnownMotion motion;
  motion.world_R_base = [](double t) { return fromEuler(0.0, 0.0, 0.1 * t); };
  EstimatedMotion observed(motion);
  observed.fly(60.0);
  EXPECT_LT(observed.estimator().gyroBias().norm(), 1e-6);
  EXPECT_NEAR(observed.last().rate.z(), 0.1, 1e-6);
}

TEST(AttitudeEstimator, StaysAccurateForTenMinutesWithNoiseAndBias) {
  KnownMotion motion = swinging(degToRad(15.0), 2.0);
  motion.gyro_bias = {0.004, -0.003, 0.005};
  motion.gyro_noise = 0.02;
  motion.force_noise = 2.0;  // vibration of the motors
  EstimatedMotion observed(motion);
  observed.fly(20.0, 200.0);
  EXPECT_LT(radToDeg(observed.fly(600.0, 200.0)), 1.5);
}

TEST(AttitudeEstimator, StaysAccurateWithChangingRatesAndGaps) {
  EstimatedMotion observed(swinging(degToRad(20.0), 2.0));
  observed.fly(5.0, 2000.0);
  EXPECT_LT(radToDeg(observed.fly(10.0, 10.0)), 1.0);
  EXPECT_LT(radToDeg(observed.fly(15.0, 500.0)), 1.0);
  observed.skip(0.4);  // integrated inaccurately, but corrected soon
  observed.fly(17.0);
  EXPECT_LT(radToDeg(observed.fly(20.0)), 1.0);
  observed.skip(30.0);  // initializes again
  EXPECT_LT(radToDeg(observed.fly(60.0)), 1.0);
}

TEST(AttitudeEstimator, DoesNotInitializeWithoutGravity) {
  AttitudeEstimator estimator{AttitudeConfig()};
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(estimator.add(0.01 * i, Vector3d::Zero(), Vector3d(0.0, 0.0, 1.0)).empty());
  }
  ASSERT_TRUE(estimator.refusedGravity());
  EXPECT_NEAR(*estimator.refusedGravity(), 1.0, 1e-12);
  std::size_t known = 0;
  for (int i = 100; i < 200; ++i) {
    known += estimator.add(0.01 * i, Vector3d::Zero(), Vector3d(0.0, 0.0, kGravity)).size();
  }
  EXPECT_GT(known, 50U);
  EXPECT_FALSE(estimator.refusedGravity());
}

TEST(AttitudeEstimator, FreeFallAndShocksCauseLittleError) {
  KnownMotion motion;
  motion.acceleration = [](double t) {
    return t > 5.0 && t < 5.5 ? Vector3d(0.0, 0.0, -kGravity)
                              : Vector3d(t > 7.0 && t < 7.05 ? 80.0 : 0.0, 0.0, 0.0);
  };
  EXPECT_LT(radToDeg(EstimatedMotion(motion).fly(20.0)), 0.5);
}

TEST(AttitudeEstimator, IgnoresStampsThatDoNotAscend) {
  AttitudeEstimator estimator{AttitudeConfig()};
  for (int i = 0; i < 100; ++i) {
    estimator.add(0.01 * i, Vector3d::Zero(), Vector3d(0.0, 0.0, kGravity));
  }
  EXPECT_TRUE(estimator.add(0.99, Vector3d::Ones(), Vector3d::Ones()).empty());
  EXPECT_TRUE(estimator.add(0.5, Vector3d::Ones(), Vector3d::Ones()).empty());
  const auto& next = estimator.add(1.0, Vector3d::Zero(), Vector3d(0.0, 0.0, kGravity));
  ASSERT_EQ(next.size(), 1U);
  EXPECT_LT(tiltOf(next[0].world_R_base), 1e-9);
}

}  // namespace
}  // namespace kestrel
