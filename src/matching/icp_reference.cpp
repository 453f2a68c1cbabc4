// SPDX-License-Identifier: BSD-3-Clause
#include "icp_reference.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// Margin of the tree around the requested area, m, so that a hovering vehicle does not need a new
/// tree.
constexpr float kSpareM = 2.0F;
/// The line of a wall is computed from this many beams to each side, up to this distance (m).
constexpr std::size_t kLineBeams = 5;
constexpr float kLineReachM = 0.4F;
/// A line needs this many hits, and this ratio of the variances along and across it.
constexpr float kMinLineHits = 3.0F, kMinElongation = 9.0F;

/// Normal of the line with the covariance (xx, xy, yy), or zero if it is not a line.
Eigen::Vector2f normalOf(float xx, float xy, float yy) {
  const Eigen::Vector2f axis2(0.5F * (xx - yy),
                              xy);  // (cos, sin) of twice the angle of the long axis, scaled
  const float root = axis2.norm(), middle = 0.5F * (xx + yy);
  if (!(root > 0.0F) || middle + root < kMinElongation * (middle - root)) {
    return Eigen::Vector2f::Zero();
  }
  const float angle = 0.5F * std::atan2(axis2.y(), axis2.x());
  return {-std::sin(angle), std::cos(angle)};
}

/// Normal, in the base frame, of the line through the hits around hit `i` of a sweep; zero if
/// unknown.
Eigen::Vector2f normalAt(const std::vector<Eigen::Vector2f>& hits, std::size_t i) {
  const std::size_t first = i < kLineBeams ? 0 : i - kLineBeams;
  const std::size_t last = std::min(i + kLineBeams, hits.size() - 1);
  float n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (std::size_t k = first; k <= last; ++k) {
    const Eigen::Vector2f p = hits[k] - hits[i];
    if (p.squaredNorm() > kLineReachM * kLineReachM) continue;
    n += 1.0F, sx += p.x(), sy += p.y();
    sxx += p.x() * p.x(), sxy += p.x() * p.y(), syy += p.y() * p.y();
  }
  if (n < kMinLineHits) return Eigen::Vector2f::Zero();
  sx /= n, sy /= n;
  return normalOf(sxx / n - sx * sx, sxy / n - sx * sy, syy / n - sy * sy);
}

std::vector<Eigen::Vector2f> positionsOf(const std::vector<WallPoint>& points) {
  std::vector<Eigen::Vector2f> positions;
  positions.reserve(points.size());
  for (const WallPoint& point : points) positions.push_back(point.position);
  return positions;
}

}  // namespace

WallPoints::WallPoints(std::vector<WallPoint> points)
    : points_(std::move(points)), tree_(positionsOf(points_)) {}

const WallPoint* WallPoints::nearest(const Eigen::Vector2f& place, float reach_m) const {
  const std::optional<std::size_t> number = tree_.nearest(place, reach_m);
  return number ? &points_[*number] : nullptr;
}

std::vector<WallPoint> surfacePoints(const Submap& map, const Eigen::AlignedBox2f& area) {
  const std::vector<Surfel> surfels = map.surface().surfelsIn(area);
  std::vector<WallPoint> points;
  points.reserve(surfels.size());
  for (const Surfel& surfel : surfels) {
    // The information matrix n n' + w t t' of a wall, converted to a matrix that is large along the
    // wall.
    points.push_back({surfel.mean, normalOf(surfel.a22, -surfel.a12, surfel.a11)});
  }
  return points;
}

std::vector<WallPoint> lastScanPoints(const Submap& map, std::size_t scans) {
  std::vector<WallPoint> points;
  const auto& keyframes = map.keyframes();
  for (std::size_t i = keyframes.size() - std::min(scans, keyframes.size()); i < keyframes.size();
       ++i) {
    const InsertedScan& scan = keyframes[i];
    const Eigen::Rotation2Df turn(static_cast<float>(scan.map_T_base.yaw));
    for (std::size_t k = 0; k < scan.hits.size(); ++k) {
      points.push_back({(scan.map_T_base * scan.hits[k].cast<double>()).cast<float>(),
                        turn * normalAt(scan.hits, k)});
    }
  }
  return points;
}

std::shared_ptr<const WallPoints> IcpReference::around(const Submap& map,
                                                       const Eigen::AlignedBox2f& area) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (revision_ == map.revision() && (last_scans_ != 0 || area_.contains(area))) return points_;
  const Eigen::Vector2f spare = Eigen::Vector2f::Constant(kSpareM);
  area_ = Eigen::AlignedBox2f(area.min() - spare, area.max() + spare);
  revision_ = map.revision();
  points_ = std::make_shared<WallPoints>(last_scans_ != 0 ? lastScanPoints(map, last_scans_)
                                                          : surfacePoints(map, area_));
  return points_;
}

}  // namespace kestrel
