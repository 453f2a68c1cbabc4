// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/odometry_chain.h"
#include "kestrel_slam/graph/odometry_worth.h"

namespace kestrel {

/// How often comparisons contradict, by the size of the contradiction.
class ContradictionRate {
 public:
  void addAgreement() { ++agreements_; }
  void add(double size) { sizes_.push_back(size); }

  /// The rate of contradictions of at least this size: its mean, with a uniform prior, and its
  /// standard deviation.
  double mean(double size) const;
  double sigma(double size) const;

 private:
  double count() const { return static_cast<double>(agreements_ + sizes_.size()) + 2.0; }

  std::size_t agreements_ = 0;
  std::vector<double> sizes_;
};

/// Contradictions between the odometry and matches. The odometry does not know whether a match is
/// good. So where doubtful matches are contradicted more than twice as often as good ones, most of
/// these contradictions are errors of the matches.
struct Contradictions {
  ContradictionRate good, doubtful;

  ContradictionRate& of(bool is_doubtful) { return is_doubtful ? doubtful : good; }
  /// Whether the odometry refutes a doubtful match. Contradictions of at least half of this size
  /// are counted, and both rates are taken a standard deviation lower: as long as few good matches
  /// were compared, the doubtful one is to blame.
  bool refutes(double contradiction) const;
};

/// The poses of an odometry that a graph uses, and the matches that they refute.
struct OdometrySelection {
  std::vector<OdometryPoint> points;
  std::vector<bool> refuted;  ///< for each keyframe
  Contradictions single;      ///< of single poses
};

/// Whether the odometry from `a` to `b` agrees with the matches of `chain`; or at least their yaws.
bool agree(const OdometryPoint& a, const OdometryPoint& b, const OdometryWorth& worth,
           const OdometryChain& chain, bool only_yaw = false);

/// Compares each pose of the odometry with the matches. There are two kinds of contradictions:
/// - single: a pose contradicts those before and after it, which agree with each other. It was
///   measured at another time, or its match is wrong.
/// - lasting: all poses from one on contradict those before it. The wheels slipped, or a match did.
///
/// An odometry that is a scan late (`is_late`) predicts wrong, so that matches slip. Only such an
/// odometry refutes doubtful matches (`doubtful`, for each keyframe); each kind is counted for
/// itself. An odometry in time is left out where it contradicts the matches for a moment, and at
/// lasting contradictions all doubtful matches count as refuted. `points`: without systematic
/// errors.
OdometrySelection selectOdometry(const std::vector<OdometryPoint>& points,
                                 const OdometryWorth& worth, const OdometryChain& chain,
                                 const std::vector<bool>& doubtful, bool is_late);

}  // namespace kestrel
