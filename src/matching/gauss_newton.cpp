// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/gauss_newton.h"

#include "surfel_lanes.h"

namespace kestrel {
namespace {

/// Sums of the normal equations, four points at a time.
struct Sums {
  Lanes h00 = Lanes::Zero(), h01 = Lanes::Zero(), h02 = Lanes::Zero(), h11 = Lanes::Zero(),
        h12 = Lanes::Zero(), h22 = Lanes::Zero();
  Lanes g0 = Lanes::Zero(), g1 = Lanes::Zero(), g2 = Lanes::Zero();

  /// Adds w (J' A J) and -w (J' A e) with J = [I, dS/dyaw], dS/dyaw = (-ry, rx) [Kohlbrecher 2011,
  /// eq. 14].
  void add(const SurfelLanes& p, const Lanes& w, const Lanes& ux, const Lanes& uy) {
    const Lanes b11 = w * p.a11, b12 = w * p.a12, b22 = w * p.a22;
    const Lanes vx = b12 * p.rx - b11 * p.ry, vy = b22 * p.rx - b12 * p.ry;
    const Lanes wx = w * ux, wy = w * uy;
    h00 += b11, h01 += b12, h11 += b22;
    h02 += vx, h12 += vy, h22 += p.rx * vy - p.ry * vx;
    g0 -= wx, g1 -= wy, g2 -= p.rx * wy - p.ry * wx;
  }

  NormalEquations equations(float cost) const {
    const float s00 = h00.sum(), s01 = h01.sum(), s02 = h02.sum();
    const float s11 = h11.sum(), s12 = h12.sum(), s22 = h22.sum();
    NormalEquations result;
    result.hessian << s00, s01, s02, s01, s11, s12, s02, s12, s22;
    result.gradient << g0.sum(), g1.sum(), g2.sum();
    result.cost = cost;
    return result;
  }
};

/// Sum of logarithms, with one logarithm for several factors.
class LogSum {
 public:
  /// The factors must be at most 1e9, so that the product of four does not overflow a float.
  void add(const Lanes& factors) {
    product_ *= factors;
    if (++count_ % kFactors == 0) flush();
  }
  float sum() {
    flush();
    return sum_.sum();
  }

 private:
  static constexpr unsigned kFactors = 4;
  void flush() {
    sum_ += product_.log();
    product_.setOnes();
  }
  Lanes product_ = Lanes::Ones(), sum_ = Lanes::Zero();
  unsigned count_ = 0;
};

template <typename Nearest>
NormalEquations linearized(const SurfelField& surface, const Points& points,
                           const Pose2& map_T_base, float scale_m, Nearest nearest) {
  const float inverse_scale2 = 1.0F / (scale_m * scale_m);
  const float reach = SurfelField::kReachCells * surface.resolution();
  Sums sums;
  LogSum log_sum;
  Lanes near = Lanes::Zero();
  const auto add = [&](const SurfelLanes& p, std::size_t /*count*/) {
    const Lanes ux = p.a11 * p.ex + p.a12 * p.ey;
    const Lanes uy = p.a12 * p.ex + p.a22 * p.ey;
    // Cauchy: cost scale²/2 log(1 + d²/scale²).
    const Lanes ratio = 1.0F + (p.ex * ux + p.ey * uy) * inverse_scale2;
    log_sum.add(ratio);
    sums.add(p, ratio.inverse(), ux, uy);
    near += p.hasSurfel();
  };
  forEachLanes(surface, points, map_T_base, nearest, add);
  const float far = static_cast<float>(points.size()) - near.sum();
  const float far_cost = std::log(1.0F + reach * reach * inverse_scale2);
  return sums.equations(0.5F * scale_m * scale_m * (log_sum.sum() + far * far_cost));
}

}  // namespace

NormalEquations linearizeDistance(const SurfelField& surface, const Points& points,
                                  const Pose2& map_T_base, float scale_m) {
  return linearized(surface, points, map_T_base, scale_m,
                    [&](std::size_t /*first*/, const FourInts& columns, const FourInts& rows) {
                      return surface.nearestOrZeros(columns, rows);
                    });
}

NormalEquations linearizeDistance(const SurfelField& surface, const Points& points,
                                  const Pose2& map_T_base, float scale_m,
                                  LastSurfels& last_surfels) {
  return linearized(surface, points, map_T_base, scale_m,
                    [&](std::size_t first, const FourInts& columns, const FourInts& rows) {
                      return last_surfels.nearest(surface, first, columns, rows);
                    });
}

NormalEquations linearizeOccupancy(const OccupancyGrid& grid, int level, const Points& points,
                                   const Pose2& map_T_base, float scale) {
  const auto c = static_cast<float>(std::cos(map_T_base.yaw));
  const auto s = static_cast<float>(std::sin(map_T_base.yaw));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  const float inverse_scale2 = 1.0F / (scale * scale);
  NormalEquations result;
  for (const Eigen::Vector2f& p : points) {
    const float rx = c * p.x() - s * p.y(), ry = s * p.x() + c * p.y();
    const InterpolatedValue m = grid.interpolate(level, {x + rx, y + ry});
    const float residual = 1.0F - m.value;
    const float ratio = 1.0F + residual * residual * inverse_scale2;
    const Eigen::Vector3f j(m.gradient.x(), m.gradient.y(),
                            rx * m.gradient.y() - ry * m.gradient.x());  // ∇M dS/dξ, eq. 14
    result.hessian += j * j.transpose() / ratio;                         // eq. 13
    result.gradient += j * (residual / ratio);                           // eq. 12
    result.cost += 0.5F * scale * scale * std::log(ratio);
  }
  return result;
}

}  // namespace kestrel
