#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel_slam {
namespace {

/// The sums of the normal equations, one scalar each, so that they stay in registers.
struct Sums {
  float h00 = 0, h01 = 0, h02 = 0, h11 = 0, h12 = 0, h22 = 0, g0 = 0, g1 = 0, g2 = 0;

  /// Adds w (J' A J) and -w (J' A e) for e = point - surface with J = [I, dS/dθ] (eq. 14).
  void add(float w, float a11, float a12, float a22, float ex, float ey, float jx, float jy) {
    const float b11 = w * a11, b12 = w * a12, b22 = w * a22;
    const float vx = b11 * jx + b12 * jy, vy = b12 * jx + b22 * jy;
    const float ux = b11 * ex + b12 * ey, uy = b12 * ex + b22 * ey;
    h00 += b11, h01 += b12, h11 += b22;
    h02 += vx, h12 += vy, h22 += jx * vx + jy * vy;
    g0 -= ux, g1 -= uy, g2 -= jx * ux + jy * uy;
  }

  NormalEquations equations(float cost) const {
    NormalEquations result;
    result.hessian << h00, h01, h02, h01, h11, h12, h02, h12, h22;
    result.gradient << g0, g1, g2;
    result.cost = cost;
    return result;
  }
};

}  // namespace

NormalEquations lineariseDistance(const SurfelField& surface, const Points& points,
                                  const Pose2& map_T_base, float scale_m) {
  const auto c = static_cast<float>(std::cos(map_T_base.theta));
  const auto s = static_cast<float>(std::sin(map_T_base.theta));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  const float inverse_scale2 = 1.0F / (scale_m * scale_m);
  const float reach = SurfelField::kReachCells * surface.resolution();
  const float far_cost = std::log(1.0F + reach * reach * inverse_scale2);
  Sums sums;
  float log_product = 0.0F, product = 1.0F;
  for (const Eigen::Vector2f& p : points) {
    const float rx = c * p.x() - s * p.y(), ry = s * p.x() + c * p.y();  // eq. 8 without the shift
    const Eigen::Vector2f point(x + rx, y + ry);
    const Surfel* surfel = surface.nearest(point);
    if (surfel == nullptr) {
      log_product += far_cost;
      continue;
    }
    const float ex = point.x() - surfel->mean.x(), ey = point.y() - surfel->mean.y();
    const float ux = surfel->a11 * ex + surfel->a12 * ey;
    const float uy = surfel->a12 * ex + surfel->a22 * ey;
    // Cauchy: cost scale²/2 log(1 + d²/scale²). The logarithm of the product of many terms is one
    // logarithm now and then instead of one a beam.
    const float ratio = 1.0F + (ex * ux + ey * uy) * inverse_scale2;
    product *= ratio;
    if (product > 1e30F) {
      log_product += std::log(product);
      product = 1.0F;
    }
    sums.add(1.0F / ratio, surfel->a11, surfel->a12, surfel->a22, ex, ey, -ry, rx);
  }
  log_product += std::log(product);
  return sums.equations(0.5F * scale_m * scale_m * log_product);
}

NormalEquations lineariseOccupancy(const OccupancyGrid& grid, int level, const Points& points,
                                   const Pose2& map_T_base, float scale) {
  const auto c = static_cast<float>(std::cos(map_T_base.theta));
  const auto s = static_cast<float>(std::sin(map_T_base.theta));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  const float inverse_scale2 = 1.0F / (scale * scale);
  Sums sums;
  float cost = 0.0F;
  for (const Eigen::Vector2f& p : points) {
    const float rx = c * p.x() - s * p.y(), ry = s * p.x() + c * p.y();
    const InterpolatedValue m = grid.interpolate(level, {x + rx, y + ry});
    const float residual = 1.0F - m.value;
    const float ratio = 1.0F + residual * residual * inverse_scale2;
    cost += std::log(ratio);
    // r = 1 - M has the gradient -∇M: with A = ∇M ∇M' the vector form e = -∇M r / |∇M|² of `add`
    // reduces to the sums of eq. 12 and 13 written out here.
    const float w = 1.0F / ratio, gx = m.gradient.x(), gy = m.gradient.y();
    const float gt = -ry * gx + rx * gy;
    sums.h00 += w * gx * gx, sums.h01 += w * gx * gy, sums.h02 += w * gx * gt;
    sums.h11 += w * gy * gy, sums.h12 += w * gy * gt, sums.h22 += w * gt * gt;
    sums.g0 += w * gx * residual, sums.g1 += w * gy * residual, sums.g2 += w * gt * residual;
  }
  return sums.equations(0.5F * scale * scale * cost);
}

}  // namespace kestrel_slam
