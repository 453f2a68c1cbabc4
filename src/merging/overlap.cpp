// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/overlap.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "remembered_loop.h"

namespace kestrel {
namespace {

/// After so many keyframes or such a way, one is compared, with so many places that are nearer than
/// this.
constexpr std::size_t kEvery = 3, kPlaces = 2;
constexpr double kEveryM = 0.7;
constexpr double kNearM = 3.0, kRadiusM = 0.4;
/// A keyframe contradicts if this share of it is known in the other map, and it fits worse.
constexpr double kKnown = 0.7, kContradictingFit = 0.6;

constexpr double kRoundM = 0.1, kRoundRad = 0.05;
constexpr std::uint64_t kExpectedMatch = 3;  ///< for the key

struct Nearest {
  double distance_m;
  std::size_t place, anchor;
};

/// The places with a keyframe near `keyframe`, nearest first.
std::vector<Nearest> nearestPlaces(const JointMap& joint, const std::vector<PoseVertex>& poses,
                                   const JointMap::Part& map, std::size_t keyframe) {
  const Eigen::Vector2d position = poses[keyframe].pose.translation();
  std::vector<Nearest> result;
  for (std::size_t p = map.first_place; p < map.last_place; ++p) {
    Nearest nearest{kNearM, p, 0};
    for (std::size_t i = joint.place(p).first; i < joint.place(p).last; ++i) {
      const double distance = (poses[i].pose.translation() - position).norm();
      if (distance < nearest.distance_m) nearest.distance_m = distance, nearest.anchor = i;
    }
    if (nearest.distance_m < kNearM) result.push_back(nearest);
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Nearest& a, const Nearest& b) { return a.distance_m < b.distance_m; });
  if (result.size() > kPlaces) result.resize(kPlaces);
  return result;
}

/// The keyframes that are compared, and the way up to each.
std::vector<std::pair<std::size_t, double>> samplesOf(const std::vector<PoseVertex>& poses,
                                                      const JointMap::Part& part) {
  std::vector<std::pair<std::size_t, double>> samples;
  double way = 0.0;
  for (std::size_t i = part.first; i < part.last; ++i) {
    if (i > part.first) way += poses[i - 1].pose.between(poses[i].pose).distance();
    if (samples.empty() || i >= samples.back().first + kEvery ||
        way >= samples.back().second + kEveryM)
      samples.emplace_back(i, way);
  }
  return samples;
}

/// Matches a keyframe where it is expected, up to a rounding: so that the search is the same one
/// when the graph has moved the maps a little.
Loop matchRounded(JointMap& joint, const LoopMatcher& matcher, std::size_t number,
                  std::size_t keyframe, const Pose2& expected, SearchMemory& memory) {
  const Pose2 begin(kRoundM * std::round(expected.x / kRoundM),
                    kRoundM * std::round(expected.y / kRoundM),
                    kRoundRad * std::round(expected.yaw / kRoundRad));
  KeyMaker key;
  key.add(kExpectedMatch);
  key.add(joint.keyOf(number));
  key.add(joint.keyOf(keyframe, keyframe + 1));
  for (const double value : {begin.x, begin.y, begin.yaw}) key.add(value);
  const KnownPlace& place = joint.place(number);
  return loopOf(memory.result(key.key(),
                              [&] {
                                return numbersOf(matcher.matchExpected(joint.mapOf(number), place,
                                                                       joint.keyframes(), keyframe,
                                                                       begin, kRadiusM),
                                                 place);
                              }),
                place, keyframe);
}

enum class Verdict { kSaysNothing, kAgrees, kContradicts };

}  // namespace

void Overlap::add(const Overlap& other) {
  agreeing.insert(agreeing.end(), other.agreeing.begin(), other.agreeing.end());
  sampled += other.sampled;
  compared += other.compared;
  contradicting += other.contradicting;
  longest_contradiction_m = std::max(longest_contradiction_m, other.longest_contradiction_m);
}

Overlap compareOverlap(JointMap& joint, const LoopMatcher& matcher,
                       const std::vector<PoseVertex>& poses, std::size_t map, std::size_t query,
                       SearchMemory& memory) {
  Overlap overlap;
  double begin = -1.0;  // of the part that contradicts
  for (const auto& [i, way] : samplesOf(poses, joint.parts()[query])) {
    Verdict verdict = Verdict::kSaysNothing;
    for (const Nearest& near : nearestPlaces(joint, poses, joint.parts()[map], i)) {
      const Pose2 expected = joint.keyframes()[near.anchor].local_T_base *
                             poses[near.anchor].pose.between(poses[i].pose);
      const Loop loop = matchRounded(joint, matcher, near.place, i, expected, memory);
      if (loop.state == LoopState::kAccepted) {
        overlap.agreeing.push_back(loop);
        verdict = Verdict::kAgrees;
      } else if (loop.known >= kKnown && loop.fit < kContradictingFit &&
                 verdict == Verdict::kSaysNothing) {
        verdict = Verdict::kContradicts;
      }
    }
    ++overlap.sampled;
    if (verdict != Verdict::kSaysNothing) ++overlap.compared;
    if (verdict == Verdict::kContradicts) {
      ++overlap.contradicting;
      if (begin < 0.0) begin = way;
      overlap.longest_contradiction_m = std::max(overlap.longest_contradiction_m, way - begin);
    } else {
      begin = -1.0;
    }
  }
  return overlap;
}

}  // namespace kestrel
