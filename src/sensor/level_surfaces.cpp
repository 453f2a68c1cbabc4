// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/level_surfaces.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {
namespace {

constexpr double kObservationPeriod = 0.045;  // s
constexpr double kMemory = 1.0;               // s; older lines are removed
constexpr double kRecent = 0.3;               // s; how long a height over the base is valid

constexpr double kMinTilt = degToRad(2.0);  // below, floor and ceiling are too far away
constexpr std::size_t kOutliers = 2;        // number of outliers allowed beyond the surface
constexpr std::size_t kMinReturns = 6;      // returns of a line
constexpr float kThickness = 0.04F;         // m; height range of the returns of a line

constexpr std::size_t kMinLines = 4;
constexpr double kMinTiltRatio = 1.25;  // ratio of the largest to the smallest tilt of the lines
constexpr double kMaxHeightDifference = 0.04;  // relative to the height
constexpr double kMinHeight = 0.4;             // m; nearer lines are ambiguous
constexpr std::size_t kCeilings = 15;          // the ceiling is the median of this many heights

}  // namespace

std::optional<LevelLine> outermostLine(std::vector<Eigen::Vector3f> returns,
                                       const Eigen::Quaterniond& stabilized_R_base, int sign) {
  const double tilt = tiltOf(stabilized_R_base);
  if (tilt < kMinTilt || returns.size() < kMinReturns + kOutliers) return std::nullopt;
  const auto up = static_cast<float>(sign);
  const auto outer = [up](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return up * a.z() > up * b.z();
  };
  const auto edge = returns.begin() + kOutliers;
  std::nth_element(returns.begin(), edge, returns.end(), outer);
  const float inner = up * edge->z() - kThickness;
  std::size_t count = 0;
  double height = 0.0;
  for (const Eigen::Vector3f& p : returns) {
    if (up * p.z() < inner) continue;
    ++count;
    height += p.z();
  }
  if (count < kMinReturns || height * sign <= 0.0) return std::nullopt;
  return LevelLine{height / static_cast<double>(count), tilt};
}

std::optional<double> LevelSurface::add(double time, const std::optional<LevelLine>& line) {
  const auto stale = [time](const Entry& entry) { return std::abs(time - entry.time) > kMemory; };
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(), stale), entries_.end());
  if (!line) return std::nullopt;
  entries_.push_back({time, *line});
  // Go back in time while the heights agree, and find the range of the tilts.
  const double height = std::abs(line->height_m);
  double min_tilt = line->tilt_rad, max_tilt = min_tilt;
  std::size_t agreeing = 0;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry, ++agreeing) {
    const double difference = std::abs(entry->line.height_m - line->height_m);
    if (difference > kMaxHeightDifference * height) break;
    min_tilt = std::min(min_tilt, entry->line.tilt_rad);
    max_tilt = std::max(max_tilt, entry->line.tilt_rad);
  }
  const bool is_level =
      agreeing >= kMinLines && max_tilt > kMinTiltRatio * min_tilt && height > kMinHeight;
  return is_level ? std::optional(line->height_m) : std::nullopt;
}

bool LevelSurfaces::isDue(double time) const {
  return !last_observation_ || std::abs(time - *last_observation_) > kObservationPeriod;
}

void LevelSurfaces::observe(double time, const std::vector<Eigen::Vector3f>& returns,
                            const Eigen::Quaterniond& stabilized_R_base,
                            const std::optional<double>& height_m) {
  last_observation_ = time;
  const auto floor = floor_.add(time, outermostLine(returns, stabilized_R_base, -1));
  if (floor) floor_over_base_ = Seen{time, *floor};
  const auto ceiling = ceiling_.add(time, outermostLine(returns, stabilized_R_base, +1));
  if (!ceiling) return;
  ceiling_over_base_ = Seen{time, *ceiling};
  const std::optional<double> height = height_m ? height_m : floorHeight(time);
  if (!height) return;
  ceilings_.push_back(*height + *ceiling);
  if (ceilings_.size() > kCeilings) ceilings_.pop_front();
}

std::optional<double> LevelSurfaces::floorHeight(double time) const {
  if (!floor_over_base_ || std::abs(time - floor_over_base_->time) > kRecent) return std::nullopt;
  return -floor_over_base_->height_m;
}

std::optional<double> LevelSurfaces::floorSeenAt(double time) const {
  if (!floor_over_base_ || floor_over_base_->time != time) return std::nullopt;
  return -floor_over_base_->height_m;
}

std::optional<double> LevelSurfaces::ceilingHeight(double time,
                                                   const std::optional<double>& height_m) const {
  if (height_m && !ceilings_.empty()) {
    std::vector<double> sorted(ceilings_.begin(), ceilings_.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle - *height_m;
  }
  if (!ceiling_over_base_ || std::abs(time - ceiling_over_base_->time) > kRecent) {
    return std::nullopt;
  }
  return ceiling_over_base_->height_m;
}

}  // namespace kestrel
