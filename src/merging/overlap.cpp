// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/overlap.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kestrel {
namespace {

/// Every so many keyframes are compared, each with so many places that are nearer than this.
constexpr std::size_t kEvery = 3, kPlaces = 2;
constexpr double kNearM = 3.0, kRadiusM = 0.4;
/// A keyframe contradicts if this share of it is known in the other map, and it fits worse.
constexpr double kKnown = 0.7, kContradictingFit = 0.6;

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
                       const std::vector<PoseVertex>& poses, std::size_t map, std::size_t query) {
  Overlap overlap;
  const JointMap::Part& part = joint.parts()[query];
  std::vector<Verdict> verdicts(part.last, Verdict::kSaysNothing);
  for (std::size_t i = part.first; i < part.last; i += kEvery) {
    for (const Nearest& near : nearestPlaces(joint, poses, joint.parts()[map], i)) {
      const Pose2 expected = joint.keyframes()[near.anchor].local_T_base *
                             poses[near.anchor].pose.between(poses[i].pose);
      const Loop loop = matcher.matchExpected(joint.mapOf(near.place), joint.place(near.place),
                                              joint.keyframes(), i, expected, kRadiusM);
      if (loop.state == LoopState::kAccepted) {
        overlap.agreeing.push_back(loop);
        verdicts[i] = Verdict::kAgrees;
      } else if (loop.known >= kKnown && loop.fit < kContradictingFit &&
                 verdicts[i] == Verdict::kSaysNothing) {
        verdicts[i] = Verdict::kContradicts;
      }
    }
  }
  double run = 0.0;
  for (std::size_t i = part.first; i < part.last; ++i) {
    if (i > part.first) run += poses[i - 1].pose.between(poses[i].pose).distance();
    if ((i - part.first) % kEvery != 0) continue;
    ++overlap.sampled;
    if (verdicts[i] != Verdict::kSaysNothing) ++overlap.compared;
    if (verdicts[i] == Verdict::kContradicts) {
      ++overlap.contradicting;
      overlap.longest_contradiction_m = std::max(overlap.longest_contradiction_m, run);
    } else {
      run = 0.0;
    }
  }
  return overlap;
}

}  // namespace kestrel
