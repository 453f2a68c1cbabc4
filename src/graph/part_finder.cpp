// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/part_finder.h"

namespace kestrel {
namespace {

/// Work of the search with every keyframe, see WorkBudget.
constexpr std::int64_t kWork = 20'000'000;

Submap mapOf(const MapperConfig& config, const std::vector<PlacedKeyframe>& keyframes) {
  Submap map(config.grid);
  for (const PlacedKeyframe& placed : keyframes)
    map.insert(placed.keyframe->planarScan(), placed.map_T_base, placed.keyframe->new_view);
  return map;
}

}  // namespace

PartFinder::PartFinder(const MapperConfig& config, const std::vector<PlacedKeyframe>& keyframes)
    : map_(mapOf(config, keyframes)),
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
