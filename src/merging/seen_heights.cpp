// SPDX-License-Identifier: BSD-3-Clause
#include "seen_heights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// Two sensors that measure the same height differ by up to this (HeightTracker).
constexpr float kSameHeightM = 0.15F;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

OccupancyGridConfig gridOfCells(double cell_m) {
  OccupancyGridConfig config;
  config.resolution_m = cell_m;
  return config;
}

double logit(double probability) { return std::log(probability / (1.0 - probability)); }

double logOddsOf(const Sighting& sighting) {
  static const OccupancyGridConfig config;
  return logit(sighting.wall ? config.hit_probability : config.miss_probability);
}

/// What both vehicles say about a point, as log odds.
struct BothSay {
  double walls = 0.0, other = 0.0;
};

BothSay operator-(const BothSay& a, const BothSay& b) {
  return {a.walls - b.walls, a.other - b.other};
}

struct AtHeight {
  float height_m;
  BothSay say;
};

BothSay sumOf(const std::vector<AtHeight>& sorted) {
  BothSay sum;
  for (const AtHeight& at : sorted) {
    sum.walls += at.say.walls;
    sum.other += at.say.other;
  }
  return sum;
}

/// What scans of unknown height say: only what speaks against an explanation.
BothSay unknownOf(const Sightings& walls, const Sightings& other) {
  BothSay unknown;
  for (const Sighting& sighting : walls) {
    if (std::isnan(sighting.height_m) && sighting.wall) unknown.walls += logOddsOf(sighting);
  }
  for (const Sighting& sighting : other) {
    if (std::isnan(sighting.height_m) && !sighting.wall) unknown.other += logOddsOf(sighting);
  }
  return unknown;
}

std::vector<AtHeight> sortedByHeight(const Sightings& walls, const Sightings& other) {
  std::vector<AtHeight> sorted;
  for (const Sighting& sighting : walls) {
    if (!std::isnan(sighting.height_m))
      sorted.push_back({sighting.height_m, {logOddsOf(sighting), 0.0}});
  }
  for (const Sighting& sighting : other) {
    if (!std::isnan(sighting.height_m))
      sorted.push_back({sighting.height_m, {0.0, logOddsOf(sighting)}});
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const AtHeight& a, const AtHeight& b) { return a.height_m < b.height_m; });
  return sorted;
}

/// The height of the next wall of the other vehicle above each entry.
std::vector<float> wallsAbove(const std::vector<AtHeight>& sorted) {
  std::vector<float> heights(sorted.size());
  float next = std::numeric_limits<float>::infinity();
  for (std::size_t i = sorted.size(); i-- > 0;) {
    heights[i] = next;
    if (sorted[i].say.other > 0.0) next = sorted[i].height_m;
  }
  return heights;
}

/// Whether one vehicle saw a wall between heights at which the other one saw free space, and up to
/// there nothing else.
bool contradictsFromBelow(const std::vector<AtHeight>& sorted, const SureCells& sure) {
  const std::vector<float> next_wall = wallsAbove(sorted);
  double below = 0.0;    // what the other vehicle says up to here
  double between = 0.0;  // what the first one says since the lowest free space
  float lowest = std::numeric_limits<float>::infinity();
  std::size_t inside = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    below += sorted[i].say.other;
    if (!(sorted[i].say.other < 0.0)) continue;
    lowest = std::min(lowest, sorted[i].height_m);
    const float highest = std::min(sorted[i].height_m, next_wall[i] - kSameHeightM);
    for (; inside < sorted.size() && sorted[inside].height_m <= highest; ++inside) {
      if (sorted[inside].height_m >= lowest) between += sorted[inside].say.walls;
    }
    if (below <= logit(sure.free) && between >= logit(sure.occupied)) return true;
  }
  return false;
}

bool isExplained(const std::vector<AtHeight>& sorted, const BothSay& unknown,
                 const SureCells& sure) {
  const double free = logit(sure.free);
  const auto explains = [&](const BothSay& here, const BothSay& there) {
    return here.walls + unknown.walls <= free && here.other <= free &&
           there.other + unknown.other > free;
  };
  const BothSay all = sumOf(sorted);
  BothSay below;
  for (std::size_t i = 0; i + 1 < sorted.size(); ++i) {
    below.walls += sorted[i].say.walls;
    below.other += sorted[i].say.other;
    if (sorted[i].height_m == sorted[i + 1].height_m) continue;
    if (explains(below, all - below) || explains(all - below, below)) return true;
  }
  return false;
}

}  // namespace

SightingCollector::SightingCollector(const std::vector<ComparedPoint>& points, double cell_m,
                                     double same_wall_m)
    : points_(points),
      grid_(gridOfCells(cell_m)),
      cell_m_(cell_m),
      same_wall_m_(same_wall_m),
      sightings_(points.size()) {}

void SightingCollector::add(PlanarScan scan, const Pose2& pose) {
  // Without the map, a beam that has no return says nothing.
  const auto isSilent = [](const PlanarRay& ray) { return ray.no_return || ray.presumed; };
  scan.rays.erase(std::remove_if(scan.rays.begin(), scan.rays.end(), isSilent), scan.rays.end());
  float reach = 0.0F;
  for (const PlanarRay& ray : scan.rays)
    reach = std::max({reach, ray.origin.norm(), ray.end.norm()});
  const double farthest = static_cast<double>(reach) + cell_m_;  // what a cell is around its center
  grid_.clear();
  grid_.insert(scan, pose);
  const Pose2 scan_T_points = pose.inverse();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if ((points_[i].at - pose.translation()).squaredNorm() > farthest * farthest) continue;
    if (!grid_.isKnown(grid_.cellAt(points_[i].at.cast<float>()))) continue;
    const Eigen::Vector2f point = (scan_T_points * points_[i].at).cast<float>();
    const float height = scan.height.isKnown() ? scan.height.at(point) : kUnknown;
    sightings_[i].push_back({height, hasWallAt(points_[i])});
  }
}

bool SightingCollector::hasWallAt(const ComparedPoint& point) const {
  const bool is_straight = !point.along.isZero();
  const Eigen::Vector2d along = is_straight ? point.along : Eigen::Vector2d::UnitX();
  const Eigen::Vector2d across(-along.y(), along.x());
  const double step = 0.5 * cell_m_;
  const auto most = std::lround(same_wall_m_ / step);
  const auto beside = is_straight ? 2 : most;
  for (auto x = -beside; x <= beside; ++x) {
    for (auto y = -most; y <= most; ++y) {
      const Eigen::Vector2d near =
          point.at + step * (static_cast<double>(x) * along + static_cast<double>(y) * across);
      if (grid_.isOccupied(grid_.cellAt(near.cast<float>()))) return true;
    }
  }
  return false;
}

HeightVerdict compareHeights(const Sightings& walls, const Sightings& other,
                             const SureCells& sure) {
  std::vector<AtHeight> sorted = sortedByHeight(walls, other);
  const bool explained = isExplained(sorted, unknownOf(walls, other), sure);
  bool contradicted = contradictsFromBelow(sorted, sure);
  for (AtHeight& at : sorted) at.height_m = -at.height_m;
  std::reverse(sorted.begin(), sorted.end());
  contradicted = contradicted || contradictsFromBelow(sorted, sure);
  return contradicted ? HeightVerdict::kContradicted
         : explained  ? HeightVerdict::kExplained
                      : HeightVerdict::kSaysNothing;
}

}  // namespace kestrel
