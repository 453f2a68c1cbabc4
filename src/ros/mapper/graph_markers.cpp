// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/graph_markers.h"

#include <cmath>
#include <cstdio>

namespace kestrel {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kPathWidth = 0.03, kLoopWidth = 0.04, kSubmapWidth = 0.1, kTextHeight = 0.3;  // m
/// Newer loops only, so that the message stays small.
constexpr std::size_t kMostTexts = 100;

geometry_msgs::Point pointOf(const Pose2& pose) {
  geometry_msgs::Point point;
  point.x = pose.x;
  point.y = pose.y;
  return point;
}

Marker markerOf(const char* ns, int type, const std::string& frame, const ros::Time& stamp) {
  Marker marker;
  marker.header.frame_id = frame;
  marker.header.stamp = stamp;
  marker.ns = ns;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.color.a = 1.0F;
  return marker;
}

/// Neighbors differ: each color is a third of the circle of colors, and a little, after the one
/// before.
std_msgs::ColorRGBA colorOf(std::size_t number) {
  constexpr double kStep = 2.4;  // rad, the golden angle
  std_msgs::ColorRGBA color;
  const auto channel = [&](int i) {
    return static_cast<float>(0.5 + 0.5 * std::cos(kStep * static_cast<double>(number) + 2.1 * i));
  };
  color.r = channel(0);
  color.g = channel(1);
  color.b = channel(2);
  color.a = 1.0F;
  return color;
}

void setColor(LoopState state, Marker& marker) {
  marker.color.r = state == LoopState::kAccepted ? 0.1F : 0.9F;
  marker.color.g = state == LoopState::kAccepted || state == LoopState::kPending ? 0.7F : 0.2F;
  marker.color.b = 0.2F;
}

}  // namespace

MarkerArray graphMarkers(const GraphView& graph, const std::string& map_frame,
                         const ros::Time& stamp) {
  MarkerArray result;
  Marker path = markerOf("keyframes", Marker::LINE_STRIP, map_frame, stamp);
  path.scale.x = kPathWidth;
  path.color.b = 1.0F;
  for (const Pose2& pose : graph.keyframes) path.points.push_back(pointOf(pose));
  if (path.points.size() > 1) result.markers.push_back(path);
  for (const LoopState state :
       {LoopState::kAccepted, LoopState::kPending, LoopState::kRefused, LoopState::kUndone}) {
    Marker lines = markerOf(toString(state), Marker::LINE_LIST, map_frame, stamp);
    lines.scale.x = kLoopWidth;
    setColor(state, lines);
    for (const Loop& loop : graph.loops) {
      if (loop.state != state) continue;
      lines.points.push_back(pointOf(graph.keyframes[loop.anchor]));
      lines.points.push_back(pointOf(graph.keyframes[loop.query]));
    }
    lines.action = lines.points.empty() ? Marker::DELETE : Marker::ADD;
    result.markers.push_back(lines);
  }
  return result;
}

MarkerArray submapMarkers(const GraphView& graph, const std::string& map_frame,
                          const ros::Time& stamp) {
  MarkerArray result;
  Marker clear = markerOf("submaps", Marker::LINE_STRIP, map_frame, stamp);
  clear.action = Marker::DELETEALL;
  result.markers.push_back(clear);
  for (const KnownPlace& submap : graph.submaps) {
    Marker path = markerOf("submaps", Marker::LINE_STRIP, map_frame, stamp);
    path.id = static_cast<int>(submap.submap);
    path.scale.x = kSubmapWidth;
    path.color = colorOf(submap.submap);
    for (std::size_t i = submap.first; i < submap.last; ++i)
      path.points.push_back(pointOf(graph.keyframes[i]));
    if (path.points.size() < 2) path.points.push_back(path.points.front());
    Marker name = markerOf("names", Marker::TEXT_VIEW_FACING, map_frame, stamp);
    name.id = path.id;
    name.scale.z = kTextHeight;
    name.color = path.color;
    name.pose.position = path.points[path.points.size() / 2];
    name.text = std::to_string(submap.submap);
    result.markers.push_back(path);
    result.markers.push_back(name);
  }
  return result;
}

MarkerArray loopMarkers(const GraphView& graph, const std::string& map_frame,
                        const ros::Time& stamp) {
  MarkerArray result;
  Marker clear = markerOf("loops", Marker::TEXT_VIEW_FACING, map_frame, stamp);
  clear.action = Marker::DELETEALL;
  result.markers.push_back(clear);
  for (std::size_t i = graph.loops.size(); i > 0 && result.markers.size() <= kMostTexts; --i) {
    const Loop& loop = graph.loops[i - 1];
    if (loop.radius_m <= 0.0) continue;
    Marker text = markerOf("loops", Marker::TEXT_VIEW_FACING, map_frame, stamp);
    text.id = static_cast<int>(i);
    text.scale.z = kTextHeight;
    text.pose.position = pointOf(graph.keyframes[loop.query]);
    setColor(loop.state, text);
    char line[200];
    std::snprintf(line, sizeof line, "%s%s%s, fit %.2f, margin %.2f, correction %.2f m",
                  toString(loop.state), loop.reason.empty() ? "" : ": ", loop.reason.c_str(),
                  loop.fit, loop.margin, loop.correction_m);
    text.text = line;
    result.markers.push_back(text);
  }
  return result;
}

}  // namespace kestrel
