// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_set>
#include <utility>

#include "kestrel_slam/session/session.h"

namespace kestrel {
namespace {

/// Larger coordinates are wrong: in floats, cells could not be told apart there.
constexpr double kMaxPositionM = 1e5;
/// Rounding may leave the two halves of a covariance this different, relative to its largest value.
constexpr double kMaxAsymmetry = 1e-9;

using Ids = std::unordered_set<std::uint64_t>;

std::string problemOfPose(const Pose2& pose) {
  if (!pose.isFinite()) return "the pose is not finite";
  if (std::abs(pose.x) > kMaxPositionM || std::abs(pose.y) > kMaxPositionM) {
    return "the pose is more than 100 km away";
  }
  return "";
}

std::string problemOfCovariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return "a covariance is not finite";
  const double largest = covariance.cwiseAbs().maxCoeff();
  if (!((covariance - covariance.transpose()).cwiseAbs().maxCoeff() <= kMaxAsymmetry * largest)) {
    return "a covariance is not symmetric";
  }
  return (covariance.diagonal().array() >= 0.0).all() ? "" : "a variance is negative";
}

/// The first text that is not empty.
std::string firstOf(std::initializer_list<std::string> problems) {
  for (const std::string& problem : problems) {
    if (!problem.empty()) return problem;
  }
  return "";
}

std::string problemOfKeyframe(const Keyframe& keyframe, bool has_place) {
  if (!std::isfinite(keyframe.stamp) || !std::isfinite(keyframe.time)) {
    return "a time is not finite";
  }
  const ScanHeight& height = keyframe.height;
  if (!std::isfinite(height.base_m) || height.base_m < 0.0F || !height.slope.allFinite())
    return "its height is not possible";
  if (!has_place) return "it is in no submap and in no vertex";
  return firstOf({problemOfPose(keyframe.submap_T_base), problemOfCovariance(keyframe.covariance),
                  problemOfCovariance(keyframe.motion_covariance)});
}

std::string problemOfLoop(const LoopRecord& loop, std::size_t vertices) {
  if (loop.from >= vertices || loop.to >= vertices) return "one of its vertices does not exist";
  for (const NamedNumber& measure : loop.measures) {
    if (!std::isfinite(measure.value)) return measure.name + " is not finite";
  }
  return firstOf(
      {problemOfPose(loop.measured.mean), problemOfCovariance(loop.measured.covariance)});
}

/// The coordinates of an odometry may have any size.
std::string problemOfOdometry(const OdometryRecord& odometry, bool has_keyframe) {
  if (!has_keyframe) return "its keyframe does not exist";
  if (odometry.own >= odometry.odom_T_base.size()) return "it has no pose of its keyframe";
  const auto isFinite = [](const Pose2& pose) { return pose.isFinite(); };
  return std::all_of(odometry.odom_T_base.begin(), odometry.odom_T_base.end(), isFinite)
             ? ""
             : "a pose is not finite";
}

/// What may be referred to.
struct Known {
  Ids keyframes, submaps, placed;

  explicit Known(const Session& session) {
    for (const KeyframePtr& keyframe : session.keyframes) {
      if (keyframe) keyframes.insert(keyframe->id);
    }
    for (const SubmapRecord& submap : session.submaps) {
      submaps.insert(submap.id);
      placed.insert(submap.keyframes.begin(), submap.keyframes.end());
    }
    for (const VertexRecord& vertex : session.vertices) {
      if (vertex.kind == VertexKind::kKeyframe) placed.insert(vertex.id);
    }
  }

  bool has(const VertexRecord& vertex) const {
    return (vertex.kind == VertexKind::kKeyframe ? keyframes : submaps).count(vertex.id) > 0;
  }
};

std::string problemOfSubmap(const SubmapRecord& submap, const Known& known) {
  for (const std::uint64_t id : submap.keyframes) {
    if (known.keyframes.count(id) == 0) return "keyframe " + std::to_string(id) + " does not exist";
  }
  return problemOfPose(submap.map_T_submap);
}

std::string problemOfVertex(const VertexRecord& vertex, const Known& known) {
  if (!known.has(vertex)) return "its keyframe or submap does not exist";
  return problemOfPose(vertex.vertex.pose);
}

/// "what 7: problem" for the first item with a problem.
template <typename Items, typename ProblemOf>
std::string firstProblem(const char* what, const Items& items, ProblemOf problem_of) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string problem = problem_of(items[i]);
    if (!problem.empty()) return what + (" " + std::to_string(i) + ": ") + problem;
  }
  return "";
}

std::string problemOfInfo(const Session& session) {
  if (!(std::isfinite(session.resolution_m) && session.resolution_m > 0.0)) {
    return "the resolution is not positive";
  }
  if (session.end && !problemOfPose(*session.end).empty()) return "its end is not a valid pose";
  return firstProblem("statistic", session.statistics, [](const NamedNumber& number) {
    return std::isfinite(number.value) ? "" : number.name + " is not finite";
  });
}

std::string problemOfIds(const Session& session, const Known& known) {
  std::set<std::pair<VertexKind, std::uint64_t>> vertices;
  for (const VertexRecord& vertex : session.vertices) vertices.insert({vertex.kind, vertex.id});
  if (std::count(session.keyframes.begin(), session.keyframes.end(), nullptr) > 0) {
    return "a keyframe is missing";
  }
  if (known.keyframes.size() != session.keyframes.size()) return "two keyframes have the same id";
  if (known.submaps.size() != session.submaps.size()) return "two submaps have the same id";
  if (vertices.size() != session.vertices.size()) return "two vertices have the same id";
  return "";
}

/// Removes the items that `is_bad` selects.
template <typename Items, typename IsBad>
void removeIf(Items& items, IsBad is_bad) {
  items.erase(std::remove_if(items.begin(), items.end(), is_bad), items.end());
}

/// Removes vertices, and edges and loops with them.
void removeVertices(Session& session, const Known& known) {
  constexpr std::size_t kGone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> new_index;
  std::size_t kept = 0;
  for (const VertexRecord& vertex : session.vertices) {
    new_index.push_back(known.has(vertex) ? kept++ : kGone);
  }
  removeIf(session.vertices, [&](const VertexRecord& vertex) { return !known.has(vertex); });
  const auto isGone = [&](auto& edge) {
    const auto renumber = [&](std::size_t i) {
      return i < new_index.size() ? new_index[i] : kGone;
    };
    edge.from = renumber(edge.from);
    edge.to = renumber(edge.to);
    return edge.from == kGone || edge.to == kGone;
  };
  removeIf(session.edges, isGone);
  removeIf(session.loops, isGone);
}

}  // namespace

std::string problemOf(const Session& session) {
  const Known known(session);
  const std::size_t vertices = session.vertices.size();
  return firstOf(
      {problemOfInfo(session), problemOfIds(session, known),
       firstProblem("keyframe", session.keyframes,
                    [&](const KeyframePtr& keyframe) {
                      return keyframe == nullptr
                                 ? ""
                                 : problemOfKeyframe(*keyframe, known.placed.count(keyframe->id));
                    }),
       firstProblem("submap", session.submaps,
                    [&](const SubmapRecord& submap) { return problemOfSubmap(submap, known); }),
       firstProblem("vertex", session.vertices,
                    [&](const VertexRecord& vertex) { return problemOfVertex(vertex, known); }),
       firstProblem("edge", session.edges,
                    [&](const PoseEdge& edge) { return problemOf(edge, vertices); }),
       firstProblem("loop", session.loops,
                    [&](const LoopRecord& loop) { return problemOfLoop(loop, vertices); }),
       firstProblem("odometry", session.odometry, [&](const OdometryRecord& odometry) {
         return problemOfOdometry(odometry, known.keyframes.count(odometry.keyframe) > 0);
       })});
}

void removeDangling(Session& session) {
  const Known known(session);
  for (SubmapRecord& submap : session.submaps) {
    removeIf(submap.keyframes, [&](std::uint64_t id) { return known.keyframes.count(id) == 0; });
  }
  removeVertices(session, known);
  removeIf(session.keyframes,
           [&](const KeyframePtr& keyframe) { return known.placed.count(keyframe->id) == 0; });
  const Known left(session);
  removeIf(session.odometry, [&](const OdometryRecord& odometry) {
    return left.keyframes.count(odometry.keyframe) == 0;
  });
}

void removeUnplaced(Session& session) {
  std::set<std::uint64_t> placed;
  for (const SubmapRecord& submap : session.submaps)
    placed.insert(submap.keyframes.begin(), submap.keyframes.end());
  removeIf(session.keyframes,
           [&](const KeyframePtr& keyframe) { return placed.count(keyframe->id) == 0; });
  removeDangling(session);
}

}  // namespace kestrel
