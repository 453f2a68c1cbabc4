// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>
#include <string>

namespace kestrel {

/// Compares the motion by the matches with what a vehicle can do. Without a motion sensor nothing
/// else shows that a scan was matched with something that moves, like the floor that a tilted laser
/// sees.
class MotionCheck {
 public:
  /// The position by a match.
  struct Entry {
    double time;                        ///< s
    Eigen::Vector2d position;           ///< in the map frame, m
    Eigen::Vector2d weak = {0.0, 0.0};  ///< a direction that the match does not show well, or zero
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the match, m²
    std::string laser = {};                                ///< PlanarScan::source
  };

  /// Whether the vehicle cannot be there, because the last positions with an acceleration of 1 g
  /// do not lead there. Weak directions do not count: a position that is corrected along a corridor
  /// is no motion. Two lasers see different walls, so the errors of their matches are independent
  /// and count. Those of one laser hardly change from scan to scan.
  bool isImpossible(const Entry& found) const;

  void add(const Entry& found);

  void clear() { last_.clear(); }

 private:
  double noiseOf(const Entry& found, const Eigen::Vector2d& missed) const;

  std::deque<Entry> last_;
};

}  // namespace kestrel
