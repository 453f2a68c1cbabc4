// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/graph_session.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "kestrel_slam/session/version.h"

namespace kestrel {
namespace {

struct Measure {
  const char* name;
  double Loop::*value;
};
constexpr Measure kMeasures[] = {{"fit", &Loop::fit},
                                 {"known", &Loop::known},
                                 {"constraint", &Loop::constraint},
                                 {"margin", &Loop::margin},
                                 {"agreement", &Loop::agreement},
                                 {"radius_m", &Loop::radius_m},
                                 {"correction_m", &Loop::correction_m}};

LoopRecord recordOf(const Loop& loop) {
  LoopRecord record{loop.anchor, loop.query, loop.anchor_T_query, loop.state, loop.reason, {}};
  for (const Measure& measure : kMeasures)
    record.measures.push_back({measure.name, loop.*measure.value});
  return record;
}

Loop loopOf(const LoopRecord& record) {
  Loop loop;
  loop.anchor = record.from;
  loop.query = record.to;
  loop.anchor_T_query = record.measured;
  loop.state = record.state;
  loop.reason = record.reason;
  for (const NamedNumber& number : record.measures) {
    for (const Measure& measure : kMeasures)
      if (number.name == measure.name) loop.*measure.value = number.value;
  }
  return loop;
}

/// The first keyframe of the submap itself: those before are of the submap before.
std::size_t firstOf(const KnownPlace& place, const GraphRecord& record) {
  std::size_t first = place.first;
  while (first + 1 < place.last && record.keyframes[first].submap != place.submap) ++first;
  return first;
}

SubmapRecord submapOf(const KnownPlace& place, bool finished, const GraphRecord& record) {
  const std::size_t first = firstOf(place, record);
  SubmapRecord submap{
      place.submap,
      record.graph.vertices[first].pose * record.keyframes[first].local_T_base.inverse(),
      finished,
      {}};
  for (std::size_t i = place.first; i < place.last; ++i)
    submap.keyframes.push_back(record.keyframes[i].keyframe->id);
  return submap;
}

/// The keyframes at the end that are in no finished submap.
KnownPlace openPlace(const GraphRecord& record) {
  const std::size_t last = record.keyframes.size();
  const std::uint32_t submap = record.keyframes.back().submap;
  if (!record.places.empty() && record.places.back().submap == submap) return {submap, last, last};
  std::size_t first = last;
  while (first > 0 && record.keyframes[first - 1].submap == submap) --first;
  return {submap, first, last};
}

[[noreturn]] void refuse(const std::string& what) {
  throw std::runtime_error("this session cannot be continued: " + what);
}

/// Puts the graph of a session together.
class Restoration {
 public:
  explicit Restoration(const Session& session) : session_(session) {}

  GraphRecord run() {
    requireVertices();
    for (std::size_t i = 0; i < session_.keyframes.size(); ++i) {
      const KeyframePtr& keyframe = session_.keyframes[i];
      index_[keyframe->id] = i;
      record_.keyframes.push_back({keyframe, kNone, keyframe->submap_T_base});
    }
    for (const SubmapRecord& submap : session_.submaps) addSubmap(submap);
    for (const LocalKeyframe& keyframe : record_.keyframes) {
      if (keyframe.submap != kNone) continue;
      refuse("keyframe " + std::to_string(keyframe.keyframe->id) + " is in no submap");
    }
    record_.graph = graphOf(session_);
    for (const LoopRecord& loop : session_.loops) record_.loops.push_back(loopOf(loop));
    for (const OdometryRecord& odometry : session_.odometry) addOdometry(odometry);
    return std::move(record_);
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  void requireVertices() const {
    bool same = session_.vertices.size() == session_.keyframes.size();
    for (std::size_t i = 0; same && i < session_.vertices.size(); ++i) {
      same = session_.vertices[i].kind == VertexKind::kKeyframe &&
             session_.vertices[i].id == session_.keyframes[i]->id;
    }
    if (!same) refuse("its vertices are not its keyframes");
  }

  void addSubmap(const SubmapRecord& submap) {
    if (submap.keyframes.empty()) return;
    if (submap.id >= kNone) refuse("a submap has the number " + std::to_string(submap.id));
    KnownPlace place{static_cast<std::uint32_t>(submap.id), index_.at(submap.keyframes.front()), 0};
    place.last = place.first;
    for (const std::uint64_t id : submap.keyframes) {
      if (index_.at(id) != place.last++)
        refuse("the keyframes of submap " + std::to_string(submap.id) + " are not consecutive");
      LocalKeyframe& keyframe = record_.keyframes[place.last - 1];
      if (keyframe.submap == kNone) keyframe.submap = place.submap;
    }
    // Older files have submaps without a keyframe of their own, too.
    if (submap.finished && hasOwnKeyframe(place, record_.keyframes))
      record_.places.push_back(place);
  }

  void addOdometry(const OdometryRecord& odometry) {
    const std::size_t number = index_.at(odometry.keyframe);
    if (!record_.odometry.empty() && record_.odometry.back().number >= number)
      refuse("its odometry is not in the order of the keyframes");
    record_.odometry.push_back(
        {number, record_.keyframes[number].local_T_base, odometry.odom_T_base, odometry.own});
  }

  const Session& session_;
  GraphRecord record_;
  std::unordered_map<std::uint64_t, std::size_t> index_;  ///< of keyframes, by their ids
};

std::string textOf(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

}  // namespace

Session sessionOf(const GraphRecord& record, double resolution_m) {
  Session session;
  session.written_by = std::string("kestrel_slam ") + kVersion;
  session.resolution_m = resolution_m;
  session.edges = record.graph.edges;
  for (std::size_t i = 0; i < record.keyframes.size(); ++i) {
    const KeyframePtr& keyframe = record.keyframes[i].keyframe;
    session.keyframes.push_back(keyframe);
    session.vertices.push_back({VertexKind::kKeyframe, keyframe->id, record.graph.vertices[i]});
  }
  for (const KnownPlace& place : record.places)
    session.submaps.push_back(submapOf(place, true, record));
  if (!record.keyframes.empty()) {
    const KnownPlace open = openPlace(record);
    if (open.last > open.first) session.submaps.push_back(submapOf(open, false, record));
  }
  for (const Loop& loop : record.loops) session.loops.push_back(recordOf(loop));
  for (const TrackedKeyframe& tracked : record.odometry)
    session.odometry.push_back(
        {record.keyframes[tracked.number].keyframe->id, tracked.odometry, tracked.own});
  return session;
}

GraphRecord graphRecordOf(const Session& session, double resolution_m) {
  if (session.resolution_m != resolution_m) {
    refuse("it has cells of " + textOf(session.resolution_m) + " m, and map_resolution is " +
           textOf(resolution_m) + "; set map_resolution to " + textOf(session.resolution_m));
  }
  return Restoration(session).run();
}

GaussianPose2 givenStart(const Pose2& map_T_base) {
  constexpr double kSigmaM = 0.5, kSigmaRad = 0.26;  // as rviz gives for a pose set by hand
  GaussianPose2 start{map_T_base, Eigen::Matrix3d::Zero()};
  start.covariance.diagonal() = Eigen::Vector3d(kSigmaM, kSigmaM, kSigmaRad).cwiseAbs2();
  return start;
}

std::optional<GaussianPose2> startAtEnd(const Session& session) {
  if (session.end) return givenStart(*session.end);
  if (session.keyframes.empty()) return std::nullopt;
  return givenStart(keyframePoses(session).back());
}

void addStatistic(Session& session, const std::string& name, double value) {
  const auto found = std::find_if(session.statistics.begin(), session.statistics.end(),
                                  [&](const NamedNumber& number) { return number.name == name; });
  if (found != session.statistics.end()) {
    found->value += value;
  } else {
    session.statistics.push_back({name, value});
  }
}

}  // namespace kestrel
