// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/part_finder.h"

namespace kestrel {
namespace {

/// Work of the search with every keyframe, see WorkBudget.
constexpr std::int64_t kWork = 20'000'000;

}  // namespace

PartFinder::PartFinder(const MapperConfig& config, const std::vector<PlacedKeyframe>& keyframes)
    : map_(submapOf(keyframes, config.grid)),
      global_(map_),
      finder_(global_, config.matcher, RelocalizationConfig()) {}

std::optional<Pose2> PartFinder::add(const PlanarScan& scan, const Pose2& local_T_base) {
  finder_.add(scan, local_T_base);
  if (!finder_.advance(kWork)) return std::nullopt;
  return finder_.mapTLocal();
}

std::size_t PartFinder::memoryBytes() const {
  return map_.memoryBytes() + global_.memoryBytes() + finder_.memoryBytes();
}

}  // namespace kestrel
