// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "filter_state.h"
#include "kestrel_slam/sensor/attitude_estimator.h"
#include "kestrel_slam/sensor/standstill.h"

namespace kestrel {

/// Finds the first attitude and the biases: from one second of standstill, or, if the vehicle
/// moves, from the mean direction of gravity.
class Initializer {
 public:
  explicit Initializer(const PoseFilterConfig& config);

  /// Adds a reading in the base frame (rad/s, m/s²); stamps (s) must ascend. Returns the first
  /// state when it is known: roll, pitch, biases and velocity with their covariance. Position and
  /// yaw are zero.
  std::optional<FilterState> add(double stamp, const Eigen::Vector3d& rate,
                                 const Eigen::Vector3d& force);

  bool startedInAir() const { return in_air_; }
  /// Why the initialization fails: wrong size or sign of gravity. Empty if nothing is wrong.
  const std::string& problem() const { return problem_; }

  /// Initializes again. `learned`: earlier biases with their covariance, which are kept.
  void restart(const std::optional<FilterState>& learned = std::nullopt);
  /// Initializes again with a larger uncertainty of the biases.
  void restartWithUncertainBiases();

 private:
  FilterState initialState(double stamp, const Eigen::Quaterniond& map_R_base) const;
  FilterState onGround(double stamp, const Eigen::Vector3d& rate);
  FilterState inAir(double stamp, const Eigen::Quaterniond& map_R_base);
  bool accepts(const Eigen::Vector3d& force);

  PoseFilterConfig config_;
  AttitudeEstimator attitude_;
  Standstill standstill_;
  std::optional<FilterState> learned_;
  bool biases_uncertain_ = false;
  bool in_air_ = false;
  std::string problem_;

  int count_ = 0;
  double first_stamp_ = 0.0, last_stamp_ = 0.0;
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  std::optional<Eigen::Quaterniond> estimated_;  ///< attitude in flight
};

}  // namespace kestrel
