// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/imu_joiner.h"

#include <cmath>

namespace kestrel {
namespace {

constexpr double kMaxGap = 0.1;  // s between two readings of the accelerometer

}  // namespace

void ImuJoiner::addGyro(double stamp, const Eigen::Vector3d& angular_velocity) {
  if (!gyro_.empty() && !(stamp > gyro_.back().stamp)) return;
  gyro_.push_back({stamp, angular_velocity});
}

void ImuJoiner::addAccelerometer(double stamp, const Eigen::Vector3d& specific_force) {
  if (!accelerometer_.empty() && !(stamp > accelerometer_.back().stamp)) return;
  accelerometer_.push_back({stamp, specific_force});
}

std::vector<ImuSample> ImuJoiner::take() {
  std::vector<ImuSample> ready;
  while (!gyro_.empty() && !accelerometer_.empty() &&
         accelerometer_.back().stamp >= gyro_.front().stamp) {
    const Reading turn = gyro_.front();
    gyro_.pop_front();
    while (accelerometer_.size() > 1 && accelerometer_[1].stamp <= turn.stamp) {
      accelerometer_.pop_front();
    }
    ImuSample sample;
    sample.stamp = turn.stamp;
    sample.angular_velocity = turn.value;
    const Reading& before = accelerometer_.front();
    const Reading& after = accelerometer_.size() > 1 ? accelerometer_[1] : before;
    const double gap = after.stamp - before.stamp;
    if (before.stamp <= turn.stamp && gap <= kMaxGap) {
      const double share = gap > 0.0 ? (turn.stamp - before.stamp) / gap : 0.0;
      sample.linear_acceleration = before.value + share * (after.value - before.value);
    }
    ready.push_back(std::move(sample));
  }
  return ready;
}

std::vector<ImuSample> ImuJoiner::finish() {
  std::vector<ImuSample> rest;
  for (const Reading& turn : gyro_) {
    rest.emplace_back();
    rest.back().stamp = turn.stamp;
    rest.back().angular_velocity = turn.value;
  }
  gyro_.clear();
  return rest;
}

}  // namespace kestrel
