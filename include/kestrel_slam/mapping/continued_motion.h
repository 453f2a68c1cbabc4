// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The motion between the last two scans, continued to the next one [Xie 2010, eq. 5-6].
///
/// Where scans are missing, the motion goes on in proportion to the time. But in a log with a scan
/// per meter the time says nothing, and if a driver delivers two scans at once, neither do the
/// stamps: then the last step is repeated. What was nearer to the matches so far is used.
class ContinuedMotion {
 public:
  /// The motion from the last scan to the next one, `seconds` later.
  Pose2 predict(double seconds) const;

  /// The step from the scan before to the last one, both of which were matched. `is_measured`:
  /// an odometry measures the motion, too.
  void add(const Pose2& step, double seconds, bool is_measured = false);

  /// The motion is unknown.
  void stop() { step_ = Pose2(); }

  /// The time between two matched scans, s.
  void addInterval(double seconds);

  /// If nothing is known about the intervals, this is a typical one, s.
  void learnInterval(double seconds);

  /// Takes the typical interval from `other` if it is known there.
  void takeInterval(const ContinuedMotion& other);

  /// Whether scans are missing in this time, s. False if the typical interval is not known.
  bool isGap(double seconds) const;

  /// Whether scans may be missing in this time, s: it isGap, or nobody knows.
  bool mayBeGap(double seconds) const { return typical_s_ == 0.0 || isGap(seconds); }

 private:
  Pose2 inProportion(double seconds) const;
  double periodsIn(double seconds) const;

  Pose2 step_;
  double periods_ = 1.0;    ///< of the laser in the last step
  double typical_s_ = 0.0;  ///< smoothed interval between two matched scans, s; 0: unknown
  bool is_first_ = true;    ///< at most one interval is known
  double proportion_error_ = 0.0, repetition_error_ = 0.0;  ///< weighted sums, m + rad
};

}  // namespace kestrel
