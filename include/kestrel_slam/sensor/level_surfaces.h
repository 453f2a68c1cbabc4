// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <vector>

namespace kestrel {

/// Returns at one height: where a tilted sweep meets floor or ceiling, or a wall straight across.
struct LevelLine {
  double height_m = 0.0;  ///< over the base; the floor's is negative
  double tilt_rad = 0.0;  ///< of the base
};

/// Tells level surfaces from walls. In one tilted sweep both may be a line of the same height; but
/// when the tilt grows, the height of a level surface stays and it comes nearer, while a wall stays
/// where it is and its height grows as the tilt does.
class LevelSurface {
 public:
  /// Adds the outermost line of the sweep at `time` (s), if it has one. Returns the height where
  /// this line and those before it are certainly a level surface.
  std::optional<double> add(double time, const std::optional<LevelLine>& line);

 private:
  struct Entry {
    double time;
    LevelLine line;
  };
  std::deque<Entry> entries_;
};

/// Floor and ceiling as the returns of a tilting laser show them.
class LevelSurfaces {
 public:
  /// Whether it is time to look at a sweep again: ten times a second are enough.
  bool isDue(double time) const;

  /// `returns`: of the sweep at `time` (s), some hundred are enough, in base_stabilized with the
  /// base as origin, m. `height_m`: of the base over the floor, where something measures it.
  void observe(double time, const std::vector<Eigen::Vector3f>& returns,
               const Eigen::Quaterniond& stabilized_R_base, const std::optional<double>& height_m);

  /// Height of the base over the floor, m, where it was seen a moment ago.
  std::optional<double> floorHeight(double time) const;
  /// The same, where the very sweep at `time` has seen it.
  std::optional<double> floorSeenAt(double time) const;

  /// Height of the ceiling over the base, m. A ceiling is remembered as long as the height over the
  /// floor is known, else for a moment.
  std::optional<double> ceilingHeight(double time, const std::optional<double>& height_m) const;

 private:
  struct Seen {
    double time;
    double height_m;
  };
  std::optional<double> last_look_;
  LevelSurface floor_, ceiling_;
  std::optional<Seen> floor_over_base_, ceiling_over_base_;
  std::deque<double> ceilings_;  ///< heights of the ceiling over the floor, as seen lately, m
};

/// The lowest (`sign` -1) or highest (+1) level line among the returns of a sweep, if there is one.
std::optional<LevelLine> outermostLine(std::vector<Eigen::Vector3f> returns,
                                       const Eigen::Quaterniond& stabilized_R_base, int sign);

}  // namespace kestrel
