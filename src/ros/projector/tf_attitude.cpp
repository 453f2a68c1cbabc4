// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/tf_attitude.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/messages/conversions.h"

namespace kestrel {
namespace {

constexpr double kStep = 0.005;      // s; tf interpolates between its slower samples
constexpr double kMaxSteps = 400.0;  // per sweep
constexpr double kRounding = 1e-6;   // s; rounding error of a stamp as double
constexpr double kClockJump = 2.0;   // s; larger: a replay was restarted

}  // namespace

TfAttitude::TfAttitude(const tf2_ros::Buffer& buffer, const std::string& world_frame,
                       const std::string& base_frame, AttitudeTracker& tracker)
    : buffer_(buffer), world_frame_(world_frame), base_frame_(base_frame), tracker_(tracker) {}

std::optional<Eigen::Quaterniond> TfAttitude::lookup(double time) const {
  if (!(time > 0.0)) return std::nullopt;  // for tf, zero means the latest time
  for (const double shift : {0.0, -kRounding, kRounding}) {
    const ros::Time stamp(time + shift);
    if (!buffer_.canTransform(world_frame_, base_frame_, stamp)) continue;
    return Eigen::Quaterniond(
        fromMessage(buffer_.lookupTransform(world_frame_, base_frame_, stamp).transform).linear());
  }
  return std::nullopt;
}

bool TfAttitude::fetch(const SweepTimes& times) {
  if (!lookup(times.last)) return false;  // the end is missing most often
  const std::optional<double> latest = tracker_.buffer().latest();
  if (latest && times.first < *latest - kClockJump) tracker_.restart();
  const double steps = std::clamp(std::ceil((times.last - times.first) / kStep), 1.0, kMaxSteps);
  for (double i = 0.0; i <= steps; ++i) {
    const double time = times.first + i / steps * (times.last - times.first);
    const std::optional<Eigen::Quaterniond> world_R_base = lookup(time);
    if (!world_R_base) return false;
    tracker_.addAttitude(time, *world_R_base);  // returns false if it is already stored
  }
  return true;
}

std::string TfAttitude::missing() const {
  return "tf has no '" + world_frame_ + "' -> '" + base_frame_ +
         "' at the time of the sweep; the source of the attitude should publish it (set "
         "~attitude_frame to its frame, or ~attitude_source to auto for an IMU)";
}

}  // namespace kestrel
