// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/track_messages.h"

#include <sensor_msgs/PointField.h>

#include <cmath>
#include <cstring>

namespace kestrel {
namespace {

using visualization_msgs::Marker;

constexpr double kMarkerHeight = 1.0, kTextHeight = 0.3, kArrowWidth = 0.06;  // m
constexpr double kSmallestBox = 0.1;                                          // m
constexpr double kPercent = 100.0;
constexpr double kMarkerLifetime = 1.0;  ///< s; also if no further message comes

geometry_msgs::Quaternion quaternionOf(double yaw) {
  geometry_msgs::Quaternion q;
  q.z = std::sin(0.5 * yaw);
  q.w = std::cos(0.5 * yaw);
  return q;
}

Marker markerOf(const kestrel_slam::TrackArray& tracks, const kestrel_slam::Track& track,
                const char* ns, int type) {
  Marker marker;
  marker.header = tracks.header;
  marker.ns = ns;
  marker.id = static_cast<int>(track.id);
  marker.type = type;
  marker.lifetime = ros::Duration(kMarkerLifetime);
  marker.pose.orientation.w = 1.0;
  marker.color.r = track.moving ? 0.9F : 0.4F;
  marker.color.g = track.moving ? 0.3F : 0.4F;
  marker.color.b = track.moving ? 0.1F : 0.9F;
  marker.color.a = track.state == kestrel_slam::Track::COASTING ? 0.4F : 0.8F;
  return marker;
}

Marker boxOf(const kestrel_slam::TrackArray& tracks, const kestrel_slam::Track& track) {
  Marker box = markerOf(tracks, track, "boxes", Marker::CUBE);
  box.pose = track.box;
  // A planar laser does not see the height.
  const bool has_height = track.box_size.z > 0.0;
  if (!has_height) box.pose.position.z = 0.5 * kMarkerHeight;
  box.scale.x = std::max(track.box_size.x, kSmallestBox);
  box.scale.y = std::max(track.box_size.y, kSmallestBox);
  box.scale.z = has_height ? track.box_size.z : kMarkerHeight;
  return box;
}

Marker arrowOf(const kestrel_slam::TrackArray& tracks, const kestrel_slam::Track& track) {
  Marker arrow = markerOf(tracks, track, "velocities", Marker::ARROW);
  arrow.points.resize(2, track.position);
  arrow.points[1].x += track.velocity.x;
  arrow.points[1].y += track.velocity.y;
  arrow.points[1].z += track.velocity.z;
  arrow.scale.x = kArrowWidth;
  arrow.scale.y = 2.0 * kArrowWidth;
  return arrow;
}

Marker textOf(const kestrel_slam::TrackArray& tracks, const kestrel_slam::Track& track) {
  Marker text = markerOf(tracks, track, "ids", Marker::TEXT_VIEW_FACING);
  text.pose.position = track.position;
  const double top =
      track.box_size.z > 0.0 ? track.box.position.z + 0.5 * track.box_size.z : kMarkerHeight;
  text.pose.position.z = top + kTextHeight;
  text.scale.z = kTextHeight;
  text.text = std::to_string(track.id);
  return text;
}

}  // namespace

kestrel_slam::Track toMessage(const Track& track) {
  kestrel_slam::Track message;
  message.id = track.id;
  message.state = static_cast<std::uint8_t>(track.state);
  message.position.x = track.position.x();
  message.position.y = track.position.y();
  message.velocity.x = track.velocity.x();
  message.velocity.y = track.velocity.y();
  for (int i = 0; i < 16; ++i) {
    message.covariance[static_cast<std::size_t>(i)] = track.covariance(i / 4, i % 4);
  }
  message.box.position.x = track.box.center.x();
  message.box.position.y = track.box.center.y();
  message.box.orientation = quaternionOf(track.box.yaw);
  message.box_size.x = track.box.size.x();
  message.box_size.y = track.box.size.y();
  message.size_class = static_cast<std::uint8_t>(track.size);
  message.age = track.age_s;
  message.unseen = track.unseen_s;
  message.moving = track.standing < 0.5;
  return message;
}

kestrel_slam::TrackArray toMessage(const Tracker::Result& result, const std::string& frame,
                                   const ros::Time& stamp) {
  kestrel_slam::TrackArray message;
  message.header.frame_id = frame;
  message.header.stamp = stamp;
  message.saturated = static_cast<std::uint8_t>(result.saturated);
  for (const Track& track : result.tracks) {
    if (track.isShown()) message.tracks.push_back(toMessage(track));
  }
  return message;
}

visualization_msgs::MarkerArray toMarkers(const kestrel_slam::TrackArray& tracks) {
  visualization_msgs::MarkerArray result;
  Marker& clear = result.markers.emplace_back();
  clear.header = tracks.header;
  clear.action = Marker::DELETEALL;
  for (const kestrel_slam::Track& track : tracks.tracks) {
    result.markers.push_back(boxOf(tracks, track));
    result.markers.push_back(arrowOf(tracks, track));
    result.markers.push_back(textOf(tracks, track));
  }
  return result;
}

sensor_msgs::PointCloud2 toCloud(const std::vector<Eigen::Vector3f>& points,
                                 const std::string& frame, const ros::Time& stamp) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.frame_id = frame;
  cloud.header.stamp = stamp;
  for (const char* name : {"x", "y", "z"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(sizeof(float) * cloud.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(points.size());
  cloud.point_step = 3 * sizeof(float);
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_dense = 1U;
  cloud.data.resize(cloud.row_step);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::memcpy(&cloud.data[i * cloud.point_step], points[i].data(), cloud.point_step);
  }
  return cloud;
}

nav_msgs::OccupancyGrid toMessage(const MotionGrid<2>& grid, const Eigen::Vector2d& center,
                                  double radius, const std::string& frame, const ros::Time& stamp) {
  nav_msgs::OccupancyGrid message;
  message.header.frame_id = frame;
  message.header.stamp = stamp;
  const auto half = static_cast<int>(std::ceil(radius / grid.resolution()));
  const GridIndex<2> first = grid.indexOf(center.cast<float>()) - GridIndex<2>::Constant(half);
  message.info.resolution = static_cast<float>(grid.resolution());
  message.info.width = message.info.height = static_cast<std::uint32_t>(2 * half + 1);
  message.info.origin.position.x = first.x() * grid.resolution();
  message.info.origin.position.y = first.y() * grid.resolution();
  message.info.origin.orientation.w = 1.0;
  message.data.reserve(std::size_t{message.info.width} * message.info.height);
  for (int y = 0; y <= 2 * half; ++y) {
    for (int x = 0; x <= 2 * half; ++x) {
      const GridIndex<2> cell = first + GridIndex<2>(x, y);
      const double probability = grid.dynamicProbability(cell);
      message.data.push_back(probability == 0.5
                                 ? std::int8_t{-1}
                                 : static_cast<std::int8_t>(std::lround(kPercent * probability)));
    }
  }
  return message;
}

}  // namespace kestrel
