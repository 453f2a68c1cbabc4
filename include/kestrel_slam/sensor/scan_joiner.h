// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// Joins the segments of a turn, for lasers that send each turn in several messages: a message that
/// begins at the angle where the previous one ended is a segment. Scans that all begin at the same
/// angle, or that cover a full turn, pass through unchanged.
///
/// The first message may have to wait for the second one, which decides what it is. Missing
/// segments leave a gap of NaN. One object for each laser (frame).
class ScanJoiner {
 public:
  /// Returns the scans that are complete now, in order; often none or one.
  std::vector<LaserScan> add(LaserScan scan);
  /// Returns what is still waiting. A turn of which less than half was received is left out.
  std::vector<LaserScan> finish();

  /// True after segments were recognized.
  bool joins() const { return joins_; }
  /// Turns that finish() left out.
  std::size_t incomplete() const { return incomplete_; }

 private:
  /// Where a message was on the circle.
  struct Place {
    double stamp, angle_min, angle_increment;
    std::size_t beams;
  };

  static Place placeOf(const LaserScan& scan);
  static bool coversTurn(const Place& place);
  static bool hasIncrement(const Place& place, double increment);
  static bool continues(const Place& first, const Place& second);

  void learn(const Place& first, const Place& second);
  bool isSegment(const Place& place) const;
  void addSegment(LaserScan segment, std::vector<LaserScan>& ready);
  std::optional<std::size_t> indexInTurn(const LaserScan& segment) const;
  void startTurn(LaserScan segment);
  void extendTurn(const LaserScan& segment, std::size_t index);
  void releaseAll(std::vector<LaserScan>& scans);

  bool joins_ = false;
  std::optional<LaserScan> waiting_;  ///< the first message, until it is known what it is
  std::optional<Place> last_;
  std::optional<LaserScan> turn_;
  double increment_ = 0.0;         ///< of the segments, rad
  double seconds_per_beam_ = 0.0;  ///< from the stamps of adjacent segments
  std::size_t beams_per_turn_ = 0, last_index_ = 0;
  std::size_t incomplete_ = 0;
};

}  // namespace kestrel
