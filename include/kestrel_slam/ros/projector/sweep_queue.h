// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <deque>
#include <string>
#include <utility>
#include <variant>

#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// One sweep of a laser, on its way through the projector's node.
struct Sweep {
  std::string topic;
  std::string frame;  ///< of the laser, without a leading slash
  ros::Time stamp;
  std::variant<LaserScan, PointCloud> data;
  SweepTimes times;  ///< what the attitude has to cover
  WaitingTime waiting;
};

/// Sweeps that wait for something, in the order of arrival. For one thread.
class SweepQueue {
 public:
  explicit SweepQueue(std::size_t capacity) : capacity_(capacity) {}

  /// False where the oldest sweep had to make room.
  bool push(Sweep sweep) {
    const bool had_room = sweeps_.size() < capacity_;
    if (!had_room) sweeps_.pop_front();
    sweeps_.push_back(std::move(sweep));
    return had_room;
  }

  /// Shows every sweep to `handle` and forgets those for which it returns true. One that has to
  /// wait does not hold up those behind it: they may be of another laser.
  template <typename Handle>
  void process(const Handle& handle) {
    for (auto sweep = sweeps_.begin(); sweep != sweeps_.end();) {
      sweep = handle(std::as_const(*sweep)) ? sweeps_.erase(sweep) : sweep + 1;
    }
  }

  std::size_t size() const { return sweeps_.size(); }

 private:
  const std::size_t capacity_;
  std::deque<Sweep> sweeps_;
};

}  // namespace kestrel
