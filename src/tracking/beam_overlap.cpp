// SPDX-License-Identifier: BSD-3-Clause
#include "beam_overlap.h"

#include <algorithm>
#include <limits>

namespace kestrel {
namespace {

constexpr std::size_t kWidest = 32;  ///< beams between two that are passed from the sensor on
/// The last cell of a ray without return is not passed, m in cells.
constexpr float kLastCell = 1.5F;
constexpr float kSmallest = std::numeric_limits<float>::min();

struct Beam {
  Eigen::Vector2f direction;
  float length = 0.0F, cleared = 0.0F;
};

Beam beamOf(const GridRay<2>& ray, float cell) {
  const Eigen::Vector2f along = ray.end - ray.origin;
  const float length = along.norm();
  return {along / length, length, ray.hit ? length : length - kLastCell * cell};
}

}  // namespace

std::vector<float> sharedWays(const std::vector<GridRay<2>>& rays, float cell) {
  std::vector<Beam> beams;
  beams.reserve(rays.size());
  for (const GridRay<2>& ray : rays) beams.push_back(beamOf(ray, cell));
  std::vector<float> shared(rays.size(), 0.0F);
  for (std::size_t i = 1; i < beams.size(); ++i) {
    const std::size_t step = i & (~i + 1);  // the largest power of two that divides i
    if (step >= kWidest || i + step >= beams.size()) continue;
    const Beam& beam = beams[i];
    const auto rangeBeside = [&](std::size_t other) {
      const float apart = (rays[i].origin - rays[other].origin).norm();
      const float spread = (beam.direction - beams[other].direction).norm();
      const float near = (0.5F * cell - apart) / std::max(spread, kSmallest);
      return std::min(near, beams[other].cleared);
    };
    // A beam without return clears less.
    if (!rays[i].presumed && (rays[i - step].presumed || rays[i + step].presumed)) continue;
    const float range = std::min({rangeBeside(i - step), rangeBeside(i + step), beam.length});
    if (range > 0.0F) shared[i] = range / beam.length;
  }
  return shared;
}

}  // namespace kestrel
