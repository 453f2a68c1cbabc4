// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The motion of a vehicle that drives the same way back: on a curve, too, it turns as before.
inline Pose2 reversed(const Pose2& motion) { return {-motion.x, -motion.y, motion.yaw}; }

/// Whether an odometry knows the direction. Encoders without a sign count forward where the vehicle
/// drives back. Forward motion shows nothing; only a vehicle that drives back does:
/// - the odometry counts back where the matches do: it knows the direction;
/// - it counts forward: it does not.
/// What was seen more often holds.
class OdometrySign {
 public:
  /// Nothing has shown that it knows the direction.
  bool mayBeMissing() const { return against_ >= for_; }
  /// It does not know the direction.
  bool isMissing() const { return against_ > for_; }

  /// Whether the next motion is against the odometry, as far as the last ones show it.
  bool isReversedNext() const { return isMissing() && chance(true) > chance(false); }
  /// Probability that isReversedNext is wrong.
  double wrongShare() const;

  /// Whether the motion that was matched is against the odometry. `error_m`: of the odometry.
  bool isReversed(const Pose2& measured, const Pose2& matched, double error_m) const;

  /// Learns how the direction changes from a motion that was matched.
  void follow(const Pose2& measured, const Pose2& matched, double error_m);

  /// Learns from a motion that was matched well in every direction.
  void learn(const Pose2& measured, const Pose2& matched, double error_m);

  /// The next motion to learn from does not continue the last one.
  void interrupt() { run_ = Run(); }

 private:
  /// Motions in a row, until they are much longer than the errors of the matches.
  struct Run {
    Pose2 measured, matched;
    double path_m = 0.0, turn_rad = 0.0, error_m = 0.0;
  };

  double chance(bool is_reversed) const;
  void learnRun();

  Run run_;
  int for_ = 0, against_ = 0;
  bool last_ = false;  ///< the last motion was against the odometry
  /// How often a motion was (second index) as, or against the odometry, after one that was (first).
  std::array<std::array<int, 2>, 2> motions_{};
};

/// An odometry in which each motion has the direction that was found. As measured, as long as none
/// was against it.
class SignedOdometry {
 public:
  /// The pose at the next scan. `is_reversed`: the motion since the last scan was against the
  /// odometry.
  std::optional<Pose2> next(const std::optional<Pose2>& odom_T_base, bool is_reversed);

 private:
  std::optional<Pose2> last_;           ///< as measured
  std::optional<Pose2> signed_T_odom_;  ///< since the first motion against the odometry
};

}  // namespace kestrel
