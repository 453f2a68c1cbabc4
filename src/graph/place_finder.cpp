// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/place_finder.h"

#include <cmath>
#include <utility>

namespace kestrel {
namespace {

/// A scan is kept after this motion, and so many are.
constexpr double kKeepM = 0.25, kKeepRad = 0.35;
constexpr std::size_t kMostParts = 16;
/// The next search begins after this motion.
constexpr double kAgainM = 0.4, kAgainRad = 0.6;
/// After this motion the searches are not limited any longer.
constexpr double kLimitedM = 3.0;

bool hasMoved(const Pose2& from, const Pose2& to, double linear_m, double angular_rad) {
  const Pose2 motion = from.between(to);
  return motion.distance() >= linear_m || std::abs(motion.yaw) >= angular_rad;
}

}  // namespace

void PlaceFinder::add(const PlanarScan& scan, const Pose2& local_T_base) {
  last_ = local_T_base;
  keep(scan, local_T_base);
  if (limit_ && !limit_->local_T_base) limit_->local_T_base = local_T_base;
  if (waiting_) return;
  if (asked_ && !search_all_ && !hasMoved(*asked_, local_T_base, kAgainM, kAgainRad)) return;
  asked_ = local_T_base;
  waiting_ = true;
  RelocalizationQuery next = query(scan, local_T_base);
  if (!search_all_) next.region = region(local_T_base);
  is_limited_ = next.region.has_value();
  search_all_ = false;
  relocalizer_.begin(std::move(next));
}

/// Where the vehicle may be at this pose.
std::optional<MapRegion> PlaceFinder::region(const Pose2& local_T_base) const {
  if (!limit_) return std::nullopt;
  const double moved = limit_->local_T_base->between(local_T_base).distance();
  if (moved > kLimitedM) return std::nullopt;
  return MapRegion{limit_->region.center, limit_->region.radius_m + moved};
}

void PlaceFinder::keep(const PlanarScan& scan, const Pose2& local_T_base) {
  if (!parts_.empty() && !hasMoved(parts_.back().local_T_base, local_T_base, kKeepM, kKeepRad))
    return;
  parts_.push_back({local_T_base, scan});
  if (parts_.size() > kMostParts) parts_.pop_front();
}

/// The scan, and those before it.
RelocalizationQuery PlaceFinder::query(const PlanarScan& scan, const Pose2& local_T_base) const {
  RelocalizationQuery result{{{Pose2(), scan}}};
  for (const Part& part : parts_) {
    if (hasMoved(part.local_T_base, local_T_base, 0.5 * kKeepM, 0.5 * kKeepRad))
      result.parts.push_back({local_T_base.between(part.local_T_base), part.scan});
  }
  return result;
}

bool PlaceFinder::advance(std::int64_t work) {
  if (!waiting_) return false;
  const RelocalizationAnswer& answer = relocalizer_.advance(work);
  if (answer.state == RelocalizationState::kSearching) return false;
  answer_ = answer;
  answered_ = asked_;
  search_all_ = is_limited_ && answer.state == RelocalizationState::kUnknown;
  waiting_ = false;
  return true;
}

std::optional<Pose2> PlaceFinder::mapTLocal() const {
  if (answer_.state != RelocalizationState::kFound) return std::nullopt;
  return answer_.pose().mean * answered_->inverse();
}

std::vector<Pose2> PlaceFinder::hypotheses() const {
  std::vector<Pose2> result;
  for (const PlaceHypothesis& hypothesis : answer_.hypotheses)
    result.push_back(hypothesis.match.pose * answered_->between(last_));
  return result;
}

void PlaceFinder::reset() {
  parts_.clear();
  asked_.reset();
  answered_.reset();
  answer_ = {};
  limit_.reset();
  search_all_ = false;
  waiting_ = false;
}

std::size_t PlaceFinder::memoryBytes() const {
  std::size_t bytes = relocalizer_.memoryBytes();
  for (const Part& part : parts_) bytes += part.scan.rays.capacity() * sizeof(PlanarRay);
  return bytes;
}

}  // namespace kestrel
