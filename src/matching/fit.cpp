#include "kestrel_slam/matching/fit.h"

#include <cmath>

namespace kestrel_slam {

Fit fitOf(const Submap& map, const Points& points, const Pose2& map_T_base, double scale_m) {
  const auto c = static_cast<float>(std::cos(map_T_base.theta));
  const auto s = static_cast<float>(std::sin(map_T_base.theta));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  const auto inverse_scale2 = static_cast<float>(1.0 / (scale_m * scale_m));
  constexpr float kOnWall = 0.5F;  // within `scale_m` of a wall
  float sum = 0, squares = 0, n11 = 0, n12 = 0, n22 = 0;
  std::size_t known = 0;
  for (const Eigen::Vector2f& p : points) {
    const Eigen::Vector2f point(x + c * p.x() - s * p.y(), y + s * p.x() + c * p.y());
    const Surfel* surfel = map.surface().nearest(point);
    float fit = 0.0F, distance2 = 0.0F;
    if (surfel != nullptr) {
      const float ex = point.x() - surfel->mean.x(), ey = point.y() - surfel->mean.y();
      distance2 = surfel->a11 * ex * ex + 2.0F * surfel->a12 * ex * ey + surfel->a22 * ey * ey;
      fit = 1.0F / (1.0F + distance2 * inverse_scale2);
    }
    if (fit > kOnWall) {
      // The surfels' own hits are known; asking the grid is only needed off the walls.
      const Eigen::Vector3f constraint = constraintOf(*surfel);
      n11 += constraint.x(), n12 += constraint.y(), n22 += constraint.z();
      squares += fit * distance2;
    } else if (!map.grid().isKnown(map.grid().cellAt(point))) {
      continue;
    }
    sum += fit;
    ++known;
  }
  Fit result;
  if (known == 0) return result;
  const auto count = static_cast<double>(known);
  result.score = static_cast<double>(sum) / count;
  result.known = count / static_cast<double>(points.size());
  result.residual_variance = static_cast<double>(squares / std::max(sum, 1.0F));
  result.normals << n11, n12, n12, n22;
  result.normals /= std::max(result.normals.trace(), 1.0);
  return result;
}

}  // namespace kestrel_slam
