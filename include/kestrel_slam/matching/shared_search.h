// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

class SurfelField;
class WallImage;

/// Whether two poses are the same bits, so that what begins there ends at the same place.
inline bool isSamePose(const Pose2& a, const Pose2& b) {
  return a.x == b.x && a.y == b.y && a.yaw == b.yaw;
}

/// What the searches for one scan in one map share: the image of the walls, and the descents from
/// the hypotheses. The windows of a scan have the same center and the same steps, so that they find
/// many of the same hypotheses. The results of a search are the same with a memory and without.
class SharedSearch {
 public:
  /// A descent from a hypothesis, or from where another one ended.
  struct Entry {
    int stage;
    Pose2 start;
    Descent descent;
  };

  /// Forgets everything if the map is another one.
  void use(const SurfelField& surface);
  const Descent* find(int stage, const Pose2& start) const;
  void add(int stage, const Pose2& start, const Descent& descent);

  const std::shared_ptr<const WallImage>& image() const { return image_; }
  void keep(std::shared_ptr<const WallImage> image) { image_ = std::move(image); }

 private:
  const SurfelField* surface_ = nullptr;
  std::vector<Entry> descents_;
  std::shared_ptr<const WallImage> image_;
};

}  // namespace kestrel
