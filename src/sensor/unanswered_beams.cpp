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

/// The share of `reach` up to the line from `a` to `b`, all from the origin of the beam. Zero if
/// the points are half a turn or more apart: then the line says nothing.
float shareToLine(const Eigen::Vector2f& a, const Eigen::Vector2f& b,
                  const Eigen::Vector2f& reach) {
  const Eigen::Vector2f line = b - a;
  const float across = cross(reach, line), share = cross(a, line) / across;
  const bool is_between = cross(a, reach) * cross(reach, b) > 0.0F && share > 0.0F;
  return is_between && std::isfinite(share) ? share : 0.0F;
}

}  // namespace

void UnansweredBeams::addReturn(const Eigen::Vector2f& end) { returns_.push_back(end); }

void UnansweredBeams::addBeam(const Eigen::Vector2f& origin, const Eigen::Vector2f& reach) {
  beams_.push_back({returns_.size(), origin, reach});
}

/// The part of `reach` that is free, 0 to 1. The last return and the first are neighbors, too.
float UnansweredBeams::freeShare(const Beam& beam) const {
  if (returns_.empty()) return 0.0F;
  const Eigen::Vector2f& before =
      beam.next_return > 0 ? returns_[beam.next_return - 1] : returns_.back();
  const Eigen::Vector2f& after =
      beam.next_return < returns_.size() ? returns_[beam.next_return] : returns_.front();
  const float share = shareToLine(before - beam.origin, after - beam.origin, beam.reach);
  return std::clamp(share - kMarginM / beam.reach.norm(), 0.0F, 1.0F);
}

void UnansweredBeams::appendTo(std::vector<PlanarRay>& rays) const {
  for (const Beam& beam : beams_) {
    const Eigen::Vector2f end = beam.origin + freeShare(beam) * beam.reach;
    PlanarRay ray{beam.origin, end, false};
    ray.no_return = true;
    rays.push_back(ray);
    PlanarRay presumed{beam.origin, beam.origin + beam.reach, false};
    presumed.presumed = true;
    if (!returns_.empty()) rays.push_back(presumed);
  }
}

}  // namespace kestrel
