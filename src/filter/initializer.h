// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "filter_state.h"
#include "kestrel_slam/sensor/attitude_estimator.h"
#include "kestrel_slam/sensor/standstill.h"

namespace kestrel {

/// Finds the first attitude and the biases: from a second of standstill, or, where the vehicle
/// moves, from what gravity says on the average.
class Initializer {
 public:
  explicit Initializer(const PoseFilterConfig& config);

  /// Takes a reading in base; stamps ascend. Returns the first state: roll, pitch, biases, velocity
  /// with their covariance; the place in map and the yaw are zero.
  std::optional<FilterState> add(double stamp, const Eigen::Vector3d& rate,
                                 const Eigen::Vector3d& force);

  bool startedInAir() const { return in_air_; }
  /// Why it cannot begin: what gravity looks like. Empty where nothing is wrong.
  const std::string& complaint() const { return complaint_; }

  /// Begins anew. `learned`: biases from before, with their covariance, are not forgotten.
  void restart(const std::optional<FilterState>& learned = std::nullopt);
  /// Begins anew, and mistrusts the IMU: its biases may be many times what they should be.
  void restartDistrustful();

 private:
  FilterState initialState(double stamp, const Eigen::Quaterniond& map_R_base) const;
  FilterState onGround(double stamp, const Eigen::Vector3d& rate);
  FilterState inAir(double stamp, const Eigen::Quaterniond& map_R_base);
  bool accepts(const Eigen::Vector3d& force);

  PoseFilterConfig config_;
  AttitudeEstimator attitude_;
  Standstill standstill_;
  std::optional<FilterState> learnt_;
  bool distrustful_ = false;
  bool in_air_ = false;
  std::string complaint_;

  int count_ = 0;
  double first_stamp_ = 0.0, last_stamp_ = 0.0;
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  std::optional<Eigen::Quaterniond> estimated_;  ///< in flight
};

}  // namespace kestrel
