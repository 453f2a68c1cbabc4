// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/common_places.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kestrel_slam/matching/place_match.h"
#include "kestrel_slam/matching/thinned.h"
#include "remembered_loop.h"

namespace kestrel {
namespace {

/// Work of the search in one place, see WorkBudget. Enough for a place of 60 m.
constexpr std::int64_t kWork = 1'000'000'000;
constexpr std::size_t kQueryPoints = 1000;
/// The query may be this far outside of the path through a place.
constexpr double kAroundM = 4.0;
/// Poses in neighboring places that differ by less are the same explanation.
constexpr double kSameM = 1.0, kSameRad = 0.35;
/// Half size of the window in which the best pose is verified.
constexpr double kVerifyRad = 0.35;

/// The hits of a query in the frame of its middle keyframe.
Points pointsOf(const std::vector<LocalKeyframe>& keyframes, const LoopQuery& query) {
  const Pose2 middle_T_local = keyframes[query.middle()].local_T_base.inverse();
  Points points;
  for (std::size_t i = query.first; i < query.last; ++i) {
    const Pose2 middle_T_base = middle_T_local * keyframes[i].local_T_base;
    for (const Eigen::Vector2f& hit : keyframes[i].keyframe->scan.hits())
      points.push_back((middle_T_base * hit.cast<double>()).cast<float>());
  }
  return sampled(points, kQueryPoints);
}

bool isSame(const Pose2& a, const Pose2& b) {
  const Pose2 difference = a.between(b);
  return difference.distance() < kSameM && std::abs(difference.yaw) < kSameRad;
}

/// What is searched for in a place.
constexpr std::uint64_t kWholePlace = 1, kVerified = 2;

SearchMemory::Key keyOf(const JointMap& joint, std::size_t place, const LoopQuery& query,
                        std::uint64_t what) {
  KeyMaker key;
  key.add(what);
  key.add(joint.keyOf(place));
  key.add(joint.keyOf(query.first, query.last));
  return key.key();
}

Loop refused(const LoopQuery& query, const char* reason) {
  Loop loop;
  loop.query = query.middle();
  loop.reason = reason;
  return loop;
}

}  // namespace

SearchMemory::Numbers CommonPlaces::searchPlace(JointMap& joint, std::size_t number,
                                                const LoopQuery& query) const {
  const KnownPlace& place = joint.place(number);
  Eigen::AlignedBox2d box;
  for (std::size_t i = place.first; i < place.last; ++i)
    box.extend(joint.keyframes()[i].local_T_base.translation());
  const Eigen::Vector2d center = box.center();
  const SearchWindow window{0.5 * box.sizes().maxCoeff() + kAroundM, kPi};
  const PlaceMatch match =
      matchPlace(joint.mapOf(number), pointsOf(joint.keyframes(), query),
                 {center.x(), center.y(), 0.0}, window, mapper_.matcher, kWork);
  const Pose2& pose = match.match.pose;
  return {pose.x, pose.y, pose.yaw, match.score, match.second_score, match.complete ? 1.0 : 0.0};
}

/// The score of the best pose that is another explanation than `best`.
double CommonPlaces::secondScore(const std::vector<Found>& found, const Found& best) {
  double second = 0.0;
  for (const Found& other : found)
    second = std::max(second, isSame(other.map, best.map) ? other.second : other.score);
  return second;
}

/// All queries in one place, then in the next one: its grid is made only once.
std::vector<Loop> CommonPlaces::search(JointMap& joint, std::size_t part,
                                       const std::vector<LoopQuery>& queries,
                                       SearchMemory& memory) const {
  std::vector<std::vector<Found>> found(queries.size());
  for (std::size_t p = joint.parts()[part].first_place; p < joint.parts()[part].last_place; ++p) {
    const Pose2 map_T_local = joint.mapTLocal(p);
    for (std::size_t q = 0; q < queries.size(); ++q) {
      const SearchMemory::Numbers& n = memory.result(keyOf(joint, p, queries[q], kWholePlace), [&] {
        return searchPlace(joint, p, queries[q]);
      });
      const Pose2 local(n[0], n[1], n[2]);
      found[q].push_back({p, local, map_T_local * local, n[3], n[4], n[5] != 0.0});
    }
  }
  std::vector<Loop> loops;
  for (std::size_t q = 0; q < queries.size(); ++q)
    loops.push_back(judged(joint, queries[q], found[q], memory));
  return loops;
}

Loop CommonPlaces::judged(JointMap& joint, const LoopQuery& query, const std::vector<Found>& found,
                          SearchMemory& memory) const {
  Found best;
  bool complete = true;
  for (const Found& one : found) {
    complete = complete && one.complete;
    if (one.score > best.score) best = one;
  }
  if (best.score < config_.min_fit * config_.min_known) return refused(query, "it does not fit");
  if (!complete) return refused(query, "the map is too large for the search");
  if (best.score - secondScore(found, best) < config_.min_margin)
    return refused(query, "it fits in several places");
  return verified(joint, query, best, memory);
}

Loop CommonPlaces::verified(JointMap& joint, const LoopQuery& query, const Found& best,
                            SearchMemory& memory) const {
  const KnownPlace& place = joint.place(best.place);
  return loopOf(
      memory.result(keyOf(joint, best.place, query, kVerified),
                    [&] {
                      return numbersOf(
                          matcher_.search(joint.mapOf(best.place), place, joint.keyframes(), query,
                                          best.local, config_.least_radius_m, kVerifyRad),
                          place);
                    }),
      place, query.middle());
}

Loop CommonPlaces::searchNear(JointMap& joint, std::size_t part, const LoopQuery& query,
                              const ExpectedPlace& expected) const {
  const Pose2 pose = expected.map_T_map * joint.poseOf(query.middle());
  const JointMap::Part& range = joint.parts()[part];
  std::size_t nearest = range.first_place, anchor = 0;
  double least = expected.radius_m + kAroundM;
  for (std::size_t p = range.first_place; p < range.last_place; ++p) {
    for (std::size_t i = joint.place(p).first; i < joint.place(p).last; ++i) {
      const double distance = joint.poseOf(i).between(pose).distance();
      if (distance < least) least = distance, nearest = p, anchor = i;
    }
  }
  if (least >= expected.radius_m + kAroundM) return refused(query, "it is too far away");
  const Pose2 local = joint.keyframes()[anchor].local_T_base * joint.poseOf(anchor).between(pose);
  return matcher_.search(joint.mapOf(nearest), joint.place(nearest), joint.keyframes(), query,
                         local, expected.radius_m, expected.yaw_rad);
}

}  // namespace kestrel
