// SPDX-License-Identifier: BSD-3-Clause
#include "unanswered_beams.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// A beam ends this far before the line: there is a wall between the returns, and it must not be
/// cleared.
constexpr float kMarginM = 0.05F;

float cross(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The share of `reach` up to the circle around the origin through the nearer of two points.
float shareToNearer(const Eigen::Vector2f& a, const Eigen::Vector2f& b,
                    const Eigen::Vector2f& reach) {
  return std::min(a.norm(), b.norm()) / reach.norm();
}

/// The share of `reach` up to the line from `a` to `b`. All from the origin of the beam.
float shareToLine(const Eigen::Vector2f& a, const Eigen::Vector2f& b,
                  const Eigen::Vector2f& reach) {
  const Eigen::Vector2f line = b - a;
  const float across = cross(reach, line), share = cross(a, line) / across;
  // The line does not cross the beam if the points are more than half a turn apart.
  const bool is_between = cross(a, reach) * cross(reach, b) > 0.0F && share > 0.0F;
  return is_between && std::isfinite(share) ? share : shareToNearer(a, b, reach);
}

}  // namespace

void UnansweredBeams::addReturn(const Eigen::Vector2f& end) { returns_.push_back(end); }

void UnansweredBeams::addBeam(const Eigen::Vector2f& origin, const Eigen::Vector2f& reach) {
  beams_.push_back({returns_.size(), origin, reach});
}

/// The part of `reach` that is free, 0 to 1.
float UnansweredBeams::shareOf(const Beam& beam, bool is_full_turn) const {
  if (returns_.empty()) return 0.0F;
  const bool has_before = beam.next_return > 0, has_after = beam.next_return < returns_.size();
  const Eigen::Vector2f* before = has_before ? &returns_[beam.next_return - 1] : nullptr;
  const Eigen::Vector2f* after = has_after ? &returns_[beam.next_return] : nullptr;
  if (before == nullptr) before = is_full_turn ? &returns_.back() : after;
  if (after == nullptr) after = is_full_turn ? &returns_.front() : before;
  const float share = shareToLine(*before - beam.origin, *after - beam.origin, beam.reach);
  const float margin = kMarginM / beam.reach.norm();
  return std::clamp(share - margin, 0.0F, 1.0F);
}

void UnansweredBeams::appendTo(std::vector<PlanarRay>& rays, bool is_full_turn) const {
  for (const Beam& beam : beams_) {
    const Eigen::Vector2f end = beam.origin + shareOf(beam, is_full_turn) * beam.reach;
    PlanarRay ray{beam.origin, end, false};
    ray.no_return = true;
    rays.push_back(ray);
  }
}

}  // namespace kestrel
