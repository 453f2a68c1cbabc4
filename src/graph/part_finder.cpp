// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/part_finder.h"

namespace kestrel {

PartFinder::PartFinder(const MapperConfig& config, const std::vector<PlacedKeyframe>& keyframes)
    : map_(submapOf(keyframes, config.grid)),
      global_(map_),
      finder_(global_, config.matcher, RelocalizationConfig()) {}

std::optional<Pose2> PartFinder::add(const PlanarScan& scan, const Pose2& local_T_base,
                                     std::int64_t work) {
  finder_.add(scan, local_T_base);
  if (!finder_.advance(work)) return std::nullopt;
  return finder_.mapTLocal();
}

std::size_t PartFinder::memoryBytes() const {
  return map_.memoryBytes() + global_.memoryBytes() + finder_.memoryBytes();
}

}  // namespace kestrel
