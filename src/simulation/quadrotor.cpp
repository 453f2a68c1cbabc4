// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "plan_path.h"
#include "sampled_motion.h"

namespace kestrel {
namespace {

using Vector6d = SampledMotion::Vector6d;
using Sample = SampledMotion::Sample;

constexpr double kStep = 1e-3;  // s

/// The acceleration caused by wind: a first-order Gauss-Markov process on each axis.
class Gusts {
 public:
  Gusts(const QuadrotorConfig& config, std::uint64_t seed)
      : random_(seed),
        decay_(std::exp(-kStep / config.gust_time_s)),
        kick_(config.gust_m_s2 * std::sqrt(1.0 - decay_ * decay_)) {}

  const Eigen::Vector3d& next() {
    for (double& axis : wind_) axis = decay_ * axis + kick_ * random_.gaussian();
    return wind_;
  }

 private:
  Random random_;
  double decay_, kick_;
  Eigen::Vector3d wind_ = Eigen::Vector3d::Zero();
};

/// The controller and the dynamics of the vehicle.
class Quadrotor {
 public:
  Quadrotor(const QuadrotorConfig& config, double max_yaw_rate)
      : config_(config), max_yaw_rate_(max_yaw_rate) {}

  /// Accelerations of position and angles in the state `now`.
  Vector6d accelerations(const Sample& now, const PathPoint& wanted,
                         const Eigen::Vector3d& wind) const {
    const Eigen::Vector3d force = wantedForce(now, wanted);
    const double roll = now.position[3], pitch = now.position[4], yaw = now.position[5];
    const double c = std::cos(yaw), s = std::sin(yaw);
    const double forward = c * force.x() + s * force.y(), left = c * force.y() - s * force.x();
    const double wanted_roll = std::atan2(-left, std::hypot(forward, force.z()));
    const double wanted_pitch = std::atan2(forward, force.z());

    // The thrust keeps the wanted vertical force while the attitude is still changing.
    const double thrust = force.z() / (std::cos(roll) * std::cos(pitch));
    const double horizontal = thrust * std::cos(roll) * std::sin(pitch);
    const double sideways = -thrust * std::sin(roll);
    Vector6d result;
    result.head<3>() = Eigen::Vector3d(c * horizontal - s * sideways, s * horizontal + c * sideways,
                                       force.z() - kGravity) +
                       wind;
    result[3] = tiltAcceleration(wanted_roll, roll, now.velocity[3]);
    result[4] = tiltAcceleration(wanted_pitch, pitch, now.velocity[4]);
    result[5] = yawAcceleration(now, wanted);
    return result;
  }

 private:
  /// Wanted force of the thrust per mass, in world, m/s², within the limits of tilt and thrust.
  Eigen::Vector3d wantedForce(const Sample& now, const PathPoint& wanted) const {
    constexpr double kStiffness = 6.0, kDamping = 4.0;                      // 1/s², 1/s
    constexpr double kMinLift = 0.3 * kGravity, kMaxLift = 2.0 * kGravity;  // m/s²
    Eigen::Vector3d force = wanted.acceleration +
                            kStiffness * (wanted.position - now.position.head<3>()) +
                            kDamping * (wanted.velocity - now.velocity.head<3>());
    force.z() = std::clamp(force.z() + kGravity, kMinLift, kMaxLift);
    const double horizontal = force.head<2>().norm();
    const double limit = force.z() * std::tan(config_.max_tilt_rad);
    if (horizontal > limit) force.head<2>() *= limit / horizontal;
    return force;
  }

  double tiltAcceleration(double wanted, double angle, double rate) const {
    const double frequency = config_.attitude_frequency_rad_s;
    return frequency * (frequency * (wanted - angle) - 2.0 * config_.attitude_damping * rate);
  }

  double yawAcceleration(const Sample& now, const PathPoint& wanted) const {
    constexpr double kYawGain = 3.0, kRateGain = 12.0;  // 1/s
    const double rate = std::clamp(wanted.yaw_rate + kYawGain * (wanted.yaw - now.position[5]),
                                   -max_yaw_rate_, max_yaw_rate_);
    const double limit = config_.yaw_acceleration_rad_s2;
    return std::clamp(kRateGain * (rate - now.velocity[5]), -limit, limit);
  }

  QuadrotorConfig config_;
  double max_yaw_rate_;
};

/// Factor of the wind. It fades to zero at the begin and end of the flight, where the vehicle
/// rests.
double windFactor(double time, double duration) {
  constexpr double kFade = 1.0;  // s
  return std::clamp(std::min(time, duration - time) / kFade, 0.0, 1.0);
}

bool rests(const Sample& sample) {
  constexpr double kStill = 1e-4;  // m/s, rad/s and their derivatives
  return sample.velocity.cwiseAbs().maxCoeff() < kStill &&
         sample.acceleration.cwiseAbs().maxCoeff() < kStill;
}

void validate(const QuadrotorConfig& config) {
  constexpr double kMaxTilt = 1.2;  // rad
  const bool good = config.max_tilt_rad > 0.0 && config.max_tilt_rad <= kMaxTilt &&
                    config.attitude_frequency_rad_s > 0.0 && config.attitude_damping > 0.0 &&
                    config.gust_m_s2 >= 0.0 && config.gust_time_s > 0.0;
  if (!good) {
    throw std::invalid_argument(
        "invalid quadrotor: max_tilt_rad must lie in (0, 1.2]; attitude_frequency_rad_s, "
        "attitude_damping and gust_time_s must be positive; gust_m_s2 must not be negative");
  }
}

}  // namespace

std::unique_ptr<Motion> flyQuadrotor(const FlightPlan& plan, const QuadrotorConfig& config,
                                     std::uint64_t seed) {
  constexpr double kMaxSettling = 15.0;  // s
  validate(config);
  const PlanPath path(plan, config.yaw_acceleration_rad_s2);
  const Quadrotor quadrotor(config, plan.yaw_rate_rad_s);
  Gusts gusts(config, seed);
  auto motion = std::make_unique<SampledMotion>(kStep);
  Sample now;
  now.position << path.at(0.0).position, 0.0, 0.0, path.at(0.0).yaw;
  motion->push(now);
  for (int i = 1;; ++i) {
    const double time = i * kStep;
    const Eigen::Vector3d wind = windFactor(time, path.duration()) * gusts.next();
    // The accelerations at the end of a step depend on the state there, so it is predicted first.
    const Sample predicted = SampledMotion::advance(now, now.acceleration, kStep);
    now =
        SampledMotion::advance(now, quadrotor.accelerations(predicted, path.at(time), wind), kStep);
    motion->push(now);
    const double settling = time - path.duration();
    if (settling > kMaxSettling || (settling > 0.0 && rests(now))) break;
  }
  if (config.level) motion->makeLevel();
  return motion;
}

}  // namespace kestrel
