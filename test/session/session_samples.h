// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "kestrel_slam/session/session.h"
#include "room.h"

namespace kestrel {

inline Eigen::Matrix3d sampleMatrix(double scale) {
  Eigen::Matrix3d matrix;
  matrix << 2.0, 0.1, -0.3, 0.1, 1.5, 0.2, -0.3, 0.2, 1.0;
  return scale * matrix;
}

/// A keyframe in the room, `beams` beams.
inline KeyframePtr sampleKeyframe(std::uint64_t id, const Pose2& map_T_base,
                                  const Pose2& map_T_submap, int beams) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->id = id;
  keyframe->stamp = 1.4e9 + 0.1 * static_cast<double>(id);
  keyframe->time = keyframe->stamp + 0.001;
  keyframe->submap_T_base = map_T_submap.inverse() * map_T_base;
  keyframe->covariance = sampleMatrix(1e-4);
  keyframe->motion_covariance = sampleMatrix(1e-5);
  keyframe->new_view = id % 3 == 0;
  keyframe->scan = CompactScan(room::scanFrom(map_T_base, room::walls(), beams).rays);
  return keyframe;
}

inline KeyframePtr atHeight(const Keyframe& keyframe, const ScanHeight& height) {
  auto result = std::make_shared<Keyframe>(keyframe);
  result->height = height;
  return result;
}

/// A session with something in every member. Each submap has three keyframes.
inline Session sampleSession(std::size_t submaps = 2, int beams = 90) {
  Session session;
  session.written_by = "kestrel_slam test";
  session.resolution_m = 0.05;
  session.parameters = "matcher: hybrid\nmap_resolution: 0.05\n";
  session.statistics = {{"scans", 100.0}, {"distance_m", 12.5}};
  session.end = Pose2(1.0, 0.5, 0.3);
  for (std::size_t s = 0; s < submaps; ++s) {
    const double shift = 0.2 * static_cast<double>(s % 9);
    const Pose2 map_T_submap(shift, 0.1, 0.05);
    SubmapRecord submap{10 + s, map_T_submap, s + 1 < submaps, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t id = 100 + 3 * s + k;
      const Pose2 map_T_base(shift + 0.1 * static_cast<double>(k), 0.2, 0.1);
      session.keyframes.push_back(sampleKeyframe(id, map_T_base, map_T_submap, beams));
      submap.keyframes.push_back(id);
      if (k > 0)
        session.odometry.push_back({id, {Pose2(5.0, 0.1, -1.0), Pose2(5.1, 0.1, -1.0)}, k - 1});
    }
    session.vertices.push_back({VertexKind::kSubmap, submap.id, {map_T_submap, s == 0}});
    if (s > 0) {
      session.edges.push_back(
          {s - 1, s, Pose2(0.2, 0.0, 0.0), sampleMatrix(1e4), EdgeKind::kOdometry});
      session.loops.push_back({s,
                               0,
                               {Pose2(-0.2, 0.01, 0.001), sampleMatrix(1e-4)},
                               s % 2 == 0 ? LoopState::kAccepted : LoopState::kRefused,
                               s % 2 == 0 ? "" : "two explanations",
                               {{"fit", 0.8}, {"margin", 0.05}}});
    }
    session.submaps.push_back(submap);
  }
  return session;
}

}  // namespace kestrel
