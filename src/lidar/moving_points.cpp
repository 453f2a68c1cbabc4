// SPDX-License-Identifier: BSD-3-Clause
#include "moving_points.h"

#include <cmath>

namespace kestrel {
namespace {

constexpr double kPointMargin = 0.15;  ///< m, around a box
constexpr float kGroundNoise = 0.06F;  ///< m

/// The box of a track in the map.
struct MarkedBox {
  Eigen::Vector2f center, u, half;
  float radius2, top;

  explicit MarkedBox(const CloudTrack& track) {
    const OrientedBox& box = track.plane.box;
    center = box.center.cast<float>();
    u = Eigen::Vector2d(std::cos(box.yaw), std::sin(box.yaw)).cast<float>();
    half = (0.5 * box.size.array() + kPointMargin).matrix().cast<float>();
    radius2 = half.squaredNorm();
    top = static_cast<float>(track.top + kPointMargin);
  }

  bool contains(const Eigen::Vector3f& point) const {
    const Eigen::Vector2f offset = point.head<2>() - center;
    if (offset.squaredNorm() > radius2 || point.z() > top) return false;
    const float across = u.x() * offset.y() - u.y() * offset.x();
    return std::abs(u.dot(offset)) <= half.x() && std::abs(across) <= half.y();
  }
};

bool liesOnGround(const PlacedSweep& sweep, std::size_t i) {
  const Eigen::Vector3f& point = sweep.usable.points[i];
  const auto& plane = sweep.ground.planeAt(point);
  return plane && plane->heightOf(point) < kGroundNoise;
}

}  // namespace

void markMovingPoints(const PlacedSweep& sweep, const std::vector<CloudTrack>& tracks,
                      std::vector<bool>& moving, std::vector<bool>& ground) {
  std::vector<MarkedBox> boxes;
  for (const CloudTrack& track : tracks) {
    if (track.isShown() && track.plane.unseen_s == 0.0) boxes.emplace_back(track);
  }
  moving.assign(sweep.cloud_size, false);
  ground.assign(sweep.cloud_size, false);
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const std::size_t number = sweep.usable.number[i];
    ground[number] = sweep.ground.is_ground[i];
    for (const MarkedBox& box : boxes) {
      if (!box.contains(sweep.points[i]) || liesOnGround(sweep, i)) continue;
      moving[number] = true;
      break;
    }
  }
}

}  // namespace kestrel
