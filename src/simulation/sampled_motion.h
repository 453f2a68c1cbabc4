// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/simulation/motion.h"

namespace kestrel {

/// A motion given by accelerations at equal time steps. The acceleration is linear between them and
/// is integrated exactly, so that the velocity is the exact derivative of the position.
class SampledMotion : public Motion {
 public:
  /// x, y, z (m, world), roll, pitch, yaw (rad, not wrapped; R = Rz(yaw) Ry(pitch) Rx(roll)).
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  struct Sample {
    Vector6d position = Vector6d::Zero();
    Vector6d velocity = Vector6d::Zero();
    Vector6d acceleration = Vector6d::Zero();
  };

  /// `step_s`: time between samples.
  explicit SampledMotion(double step_s) : step_s_(step_s) {}

  /// The sample at `elapsed` (s) after `from`, if the acceleration changes linearly to
  /// `acceleration`.
  static Sample advance(const Sample& from, const Vector6d& acceleration, double elapsed);

  void push(const Sample& sample) { samples_.push_back(sample); }
  /// Sets roll and pitch to zero and keeps the path.
  void makeLevel();

  double duration() const override;
  TrueState at(double time) const override;

 private:
  double step_s_;
  std::vector<Sample> samples_;
};

}  // namespace kestrel
