// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <vector>

namespace kestrel {

/// Returns at one height: the line where a tilted sweep meets the floor, the ceiling, or a wall
/// perpendicular to the tilt direction.
struct LevelLine {
  double height_m = 0.0;  ///< over the base; negative for the floor
  double tilt_rad = 0.0;  ///< of the base
};

/// Distinguishes level surfaces from walls. In a single tilted sweep both are a line at one height.
/// When the tilt grows, the line on a level surface keeps its height and comes nearer. The line on
/// a wall keeps its distance, and its height grows with the tilt.
class LevelSurface {
 public:
  /// Adds the outermost line of the sweep at `time` (s), if it has one. Returns its height (m, over
  /// the base) if this line and the earlier ones show a level surface.
  std::optional<double> add(double time, const std::optional<LevelLine>& line);

 private:
  struct Entry {
    double time;
    LevelLine line;
  };
  std::deque<Entry> entries_;
};

/// Height of floor and ceiling from the returns of a tilting laser.
class LevelSurfaces {
 public:
  /// Whether the sweep at `time` (s) should be observed: about 20 sweeps per second are enough.
  bool isDue(double time) const;

  /// Adds a sweep. `returns`: end points of the sweep at `time` (s) in base_stabilized, origin at
  /// the base, m; about a hundred are enough. `height_m`: height of the base over the floor, if it
  /// is measured.
  void observe(double time, const std::vector<Eigen::Vector3f>& returns,
               const Eigen::Quaterniond& stabilized_R_base, const std::optional<double>& height_m);

  /// Height of the base over the floor, m, if the floor was seen recently.
  std::optional<double> floorHeight(double time) const;
  /// The same, only if the sweep at `time` itself has seen the floor.
  std::optional<double> floorSeenAt(double time) const;

  /// Height of the ceiling over the base, m. If the height over the floor is known, the last
  /// ceiling is used, even if it is old; else only a recent one.
  std::optional<double> ceilingHeight(double time, const std::optional<double>& height_m) const;

 private:
  struct Seen {
    double time;
    double height_m;
  };
  std::optional<double> last_observation_;
  LevelSurface floor_, ceiling_;
  std::optional<Seen> floor_over_base_, ceiling_over_base_;
  std::deque<double> ceilings_;  ///< latest heights of the ceiling over the floor, m
};

/// The lowest (`sign` -1) or highest (`sign` +1) line of returns at one height, if there is one.
std::optional<LevelLine> outermostLine(std::vector<Eigen::Vector3f> returns,
                                       const Eigen::Quaterniond& stabilized_R_base, int sign);

}  // namespace kestrel
