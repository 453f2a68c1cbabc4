// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_track_messages.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/track_messages.h"

namespace kestrel {
namespace {

constexpr double kUnknown = 0.5;
constexpr double kPercent = 100.0;
constexpr double kBelow = 3.0, kAbove = 3.0;  ///< m, from the lidar: where road users are

/// Position, velocity, covariance and box in another frame, seen from above.
Track movedBy(const Pose2& frame_T_map, Track track) {
  const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(frame_T_map.yaw).toRotationMatrix();
  Eigen::Matrix4d both = Eigen::Matrix4d::Zero();
  both.topLeftCorner<2, 2>() = both.bottomRightCorner<2, 2>() = rotation;
  track.position = frame_T_map * track.position;
  track.velocity = rotation * track.velocity;
  track.covariance = both * track.covariance * both.transpose();
  track.box.center = frame_T_map * track.box.center;
  track.box.yaw += frame_T_map.yaw;
  return track;
}

std::int8_t valueOf(const MotionGrid<3>& grid, GridIndex<3> cell, int top) {
  double largest = -1.0;
  for (; cell.z() <= top; ++cell.z()) {
    const double probability = grid.dynamicProbability(cell);
    if (probability != kUnknown) largest = std::max(largest, probability);
  }
  return static_cast<std::int8_t>(largest < 0.0 ? -1 : std::lround(kPercent * largest));
}

}  // namespace

kestrel_slam::Track toMessage(const CloudTrack& track, const Eigen::Isometry3d& frame_T_map) {
  kestrel_slam::Track message = toMessage(movedBy(toPose2(frame_T_map), track.plane));
  const double shift = frame_T_map.translation().z();
  message.position.z = track.z + shift;
  message.velocity.z = track.climb;
  message.box.position.z = 0.5 * (track.bottom + track.top) + shift;
  message.box_size.z = track.top - track.bottom;
  return message;
}

nav_msgs::OccupancyGrid toMessage(const MotionGrid<3>& grid, const Eigen::Vector3d& center,
                                  double radius, const Eigen::Isometry3d& frame_T_map) {
  const auto half = static_cast<int>(std::ceil(radius / grid.resolution()));
  const GridIndex<3> middle = grid.indexOf(center.cast<float>());
  const int bottom = middle.z() - static_cast<int>(kBelow / grid.resolution());
  const int top = middle.z() + static_cast<int>(kAbove / grid.resolution());
  nav_msgs::OccupancyGrid message;
  message.info.resolution = static_cast<float>(grid.resolution());
  message.info.width = message.info.height = static_cast<std::uint32_t>(2 * half + 1);
  const Eigen::Vector2d corner =
      grid.resolution() * (middle.head<2>().array() - half).cast<double>().matrix();
  message.info.origin = toMessage(toPose2(frame_T_map) * Pose2(corner.x(), corner.y(), 0.0));
  message.data.reserve(std::size_t{message.info.width} * message.info.height);
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      message.data.push_back(valueOf(grid, {middle.x() + x, middle.y() + y, bottom}, top));
    }
  }
  return message;
}

}  // namespace kestrel
