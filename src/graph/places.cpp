// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/places.h"

#include <algorithm>
#include <utility>

namespace kestrel {

bool hasOwnKeyframe(const KnownPlace& place, const std::vector<LocalKeyframe>& keyframes) {
  for (std::size_t i = place.first; i < place.last; ++i)
    if (keyframes[i].submap == place.submap) return true;
  return false;
}

void Places::add(std::uint32_t submap, std::size_t first, std::size_t last) {
  places_.push_back({submap, first, last});
}

const Submap& Places::mapOf(std::size_t place, const std::vector<LocalKeyframe>& keyframes) {
  const auto found = std::find_if(cache_.begin(), cache_.end(),
                                  [&](const Cached& cached) { return cached.place == place; });
  if (found != cache_.end()) {
    cache_.splice(cache_.begin(), cache_, found);
    return *cache_.front().map;
  }
  auto map = std::make_unique<Submap>(config_.matchedGrid());
  for (std::size_t i = places_[place].first; i < places_[place].last; ++i) {
    const LocalKeyframe& entry = keyframes[i];
    map->insert(entry.keyframe->planarScan(), entry.local_T_base, entry.keyframe->new_view);
  }
  cache_.push_front({place, std::move(map)});
  cached_bytes_ += cache_.front().map->memoryBytes();
  while (cached_bytes_ > max_cached_bytes_ && cache_.size() > 1) {
    cached_bytes_ -= cache_.back().map->memoryBytes();
    cache_.pop_back();
  }
  return *cache_.front().map;
}

std::size_t Places::memoryBytes() const {
  return places_.capacity() * sizeof(KnownPlace) + cached_bytes_;
}

}  // namespace kestrel
