// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "kestrel_slam/map/keyframe.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper_config.h"

namespace kestrel {

/// A keyframe and where it was inserted.
struct LocalKeyframe {
  KeyframePtr keyframe;
  std::uint32_t submap = 0;
  Pose2 local_T_base;  ///< in the local frame of the mapper
};

/// A finished submap in the local frame.
struct KnownPlace {
  std::uint32_t submap = 0;
  std::size_t first = 0, last = 0;  ///< its keyframes [first, last)
};

/// Whether the submap has a keyframe of its own. Those at its beginning may all belong to the
/// submap before, with which it overlaps; such a submap shows nothing more, and its number may be
/// used again.
bool hasOwnKeyframe(const KnownPlace& place, const std::vector<LocalKeyframe>& keyframes);

/// The finished submaps. Their grids are caches: only those that were used last are in memory, and
/// the others are built again from the keyframes when they are needed.
class Places {
 public:
  /// Memory of the grids. A vehicle searches the same few places for a while.
  static constexpr std::size_t kCachedBytes = 16'000'000;

  explicit Places(const MapperConfig& config, std::size_t cached_bytes = kCachedBytes)
      : config_(config), max_cached_bytes_(cached_bytes) {}

  /// Adds the submap of the keyframes [first, last).
  void add(std::uint32_t submap, std::size_t first, std::size_t last);

  const std::vector<KnownPlace>& all() const { return places_; }

  /// The grid of a place. Valid until other grids are asked for.
  const Submap& mapOf(std::size_t place, const std::vector<LocalKeyframe>& keyframes);

  std::size_t memoryBytes() const;

 private:
  struct Cached {
    std::size_t place;
    std::unique_ptr<Submap> map;
  };

  MapperConfig config_;
  std::size_t max_cached_bytes_;
  std::vector<KnownPlace> places_;
  std::list<Cached> cache_;  ///< last used first
  std::size_t cached_bytes_ = 0;
};

}  // namespace kestrel
