// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/shared_search.h"

#include <algorithm>

namespace kestrel {
void SharedSearch::use(const SurfelField& surface) {
  if (surface_ == &surface) return;
  surface_ = &surface;
  descents_.clear();
  image_.reset();
}

const Descent* SharedSearch::find(int stage, const Pose2& start) const {
  const auto found = std::find_if(descents_.begin(), descents_.end(), [&](const Entry& entry) {
    return entry.stage == stage && isSamePose(entry.start, start);
  });
  return found == descents_.end() ? nullptr : &found->descent;
}

void SharedSearch::add(int stage, const Pose2& start, const Descent& descent) {
  descents_.push_back({stage, start, descent});
}

}  // namespace kestrel
