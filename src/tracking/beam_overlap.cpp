// SPDX-License-Identifier: BSD-3-Clause
#include "beam_overlap.h"

#include <algorithm>
#include <limits>

namespace kestrel {
namespace {

constexpr std::size_t kWidest = 32;  ///< beams between two that are passed from the sensor on
/// The last cell of a ray is not passed, m in cells.
constexpr float kLastCell = 1.5F;

struct Beam {
  Eigen::Vector2f origin, direction;
  float length;
  bool presumed;

  explicit Beam(const GridRay<2>& ray) : origin(ray.origin), presumed(ray.presumed) {
    const Eigen::Vector2f along = ray.end - ray.origin;
    length = along.norm();
    direction = along / length;
  }
};

/// Up to which range the other beam is within `distance` of this one. Not a number is no range.
float rangeBeside(const Beam& beam, const Beam& other, float distance, float cell) {
  // A beam without return clears less.
  if (other.presumed && !beam.presumed) return 0.0F;
  const float apart = (beam.origin - other.origin).norm();
  const float spread = (beam.direction - other.direction).norm();
  const float range = (distance - apart) / std::max(spread, std::numeric_limits<float>::min());
  const float shared = std::min(range, other.length - kLastCell * cell);
  return shared > 0.0F ? shared : 0.0F;
}

}  // namespace

std::vector<float> sharedRanges(const std::vector<GridRay<2>>& rays, float cell) {
  std::vector<Beam> beams;
  beams.reserve(rays.size());
  for (const GridRay<2>& ray : rays) beams.emplace_back(ray);
  std::vector<float> shared(rays.size(), 0.0F);
  const float distance = 0.5F * cell;
  for (std::size_t i = 1; i < rays.size(); ++i) {
    const std::size_t step = i & (~i + 1);  // the largest power of two that divides i
    if (step >= kWidest || i + step >= rays.size()) continue;
    const float left = rangeBeside(beams[i], beams[i - step], distance, cell);
    const float right = rangeBeside(beams[i], beams[i + step], distance, cell);
    shared[i] = std::min({left, right, beams[i].length});
  }
  return shared;
}

}  // namespace kestrel
