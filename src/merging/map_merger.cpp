// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/map_merger.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "far_places.h"
#include "joint_solution.h"
#include "kestrel_slam/merging/wall_comparison.h"

namespace kestrel {
namespace {

/// The second explanation is similar if it has more than this share of the loops of the first.
constexpr double kSimilar = 0.5;

std::string text(std::size_t count, const char* what) { return std::to_string(count) + what; }

std::string meters(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.1f m", value);
  return buffer;
}

std::string tooFew(const PairResult& result, const MergingConfig& config) {
  return "only " + text(result.first, " matches at ") + text(result.places, " places") +
         " agree; " + text(config.min_loops, " at ") + text(config.min_places, " are needed");
}

}  // namespace

const char* toString(PairState state) {
  switch (state) {
    case PairState::kJoined:
      return "joined";
    case PairState::kGiven:
      return "given";
    case PairState::kNoOverlap:
      return "no overlap found";
    case PairState::kAmbiguous:
      return "ambiguous";
    case PairState::kContradicted:
      return "contradicted";
    case PairState::kUndone:
      return "undone";
    case PairState::kSeparated:
      return "separated";
    default:
      return "unusable";
  }
}

std::size_t MergeResult::largestGroup() const {
  std::size_t largest = 0;
  for (const std::size_t first : group)
    largest =
        std::max(largest, static_cast<std::size_t>(std::count(group.begin(), group.end(), first)));
  return largest;
}

MapMerger::MapMerger(const MapperConfig& mapper, const LoopConfig& loops,
                     const MergingConfig& config)
    : mapper_(mapper),
      loop_config_(loops),
      config_(config),
      places_(mapper, loops),
      matcher_(mapper.matcher, loops) {}

std::size_t MapMerger::update(VehicleMap map) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    if (vehicles_[i].name != map.name) continue;
    vehicles_[i] = std::move(map);
    return i;
  }
  vehicles_.push_back(std::move(map));
  for (std::size_t i = 0; i + 1 < vehicles_.size(); ++i) {
    pairs_.emplace_back();
    pairs_.back().a = i;
    pairs_.back().b = vehicles_.size() - 1;
  }
  return vehicles_.size() - 1;
}

MapMerger::Pair& MapMerger::pairOf(std::size_t a, std::size_t b) {
  return pairs_[std::max(a, b) * (std::max(a, b) - 1) / 2 + std::min(a, b)];
}

void MapMerger::separate(std::size_t a, std::size_t b) {
  if (a != b) pairOf(a, b).separated = true;
}

/// a_T_b of the maps by the poses that were given.
std::optional<Pose2> MapMerger::guessOf(const Pair& pair) const {
  const auto &a = vehicles_[pair.a].world_T_map, &b = vehicles_[pair.b].world_T_map;
  if (!a || !b) return std::nullopt;
  return a->between(*b);
}

MergeResult MapMerger::merge() {
  std::vector<const VehicleMap*> maps;
  for (const VehicleMap& vehicle : vehicles_) maps.push_back(&vehicle);
  JointMap joint(mapper_, maps);
  std::vector<Decision> decisions;
  for (Pair& pair : pairs_) {
    if (!pair.separated) search(joint, pair);
    decisions.push_back(decide(joint, pair));
  }
  MergeResult result;
  optimizeAll(joint, decisions, result);
  for (Decision& decision : decisions) result.pairs.push_back(std::move(decision.result));
  place(joint, result);
  memory_.forgetUnused();
  return result;
}

void MapMerger::search(JointMap& joint, Pair& pair) {
  pair.searched = 0;
  pair.loops.clear();
  if (!problemOf(vehicles_[pair.a]).empty() || !problemOf(vehicles_[pair.b]).empty()) return;
  searchQueries(joint, pair, false);
  searchQueries(joint, pair, true);
}

/// Searches for the queries of one vehicle in the map of the other.
void MapMerger::searchQueries(JointMap& joint, Pair& pair, bool query_in_a) {
  const std::size_t from = query_in_a ? pair.a : pair.b, in = query_in_a ? pair.b : pair.a;
  const std::size_t offset = joint.parts()[from].first;
  const std::optional<Pose2> guess = guessOf(pair);
  std::vector<LoopQuery> unknown;
  for (const LoopQuery& query : chosen(queriesOf(vehicles_[from], loop_config_))) {
    const LoopQuery moved{query.first + offset, query.last + offset};
    ++pair.searched;
    Loop loop;
    if (guess)
      loop = places_.searchNear(joint, in, moved, {query_in_a ? guess->inverse() : *guess});
    if (loop.state == LoopState::kPending) {
      pair.loops.push_back(loop);
    } else {
      unknown.push_back(moved);
    }
  }
  for (const Loop& loop : places_.search(joint, in, unknown, memory_))
    if (loop.state == LoopState::kPending) pair.loops.push_back(loop);
}

/// Every n-th query. n is a power of two, so that those of a larger map were already chosen when it
/// was smaller.
std::vector<LoopQuery> MapMerger::chosen(const std::vector<LoopQuery>& queries) const {
  std::size_t step = 1;
  while (queries.size() > step * config_.max_queries) step *= 2;
  std::vector<LoopQuery> result;
  for (std::size_t i = step - 1; i < queries.size(); i += step) result.push_back(queries[i]);
  return result;
}

MapMerger::Decision MapMerger::decide(JointMap& joint, const Pair& pair) {
  Decision decision;
  PairResult& result = decision.result;
  result.a = pair.a;
  result.b = pair.b;
  result.searched = pair.searched;
  for (const std::size_t vehicle : {pair.a, pair.b}) {
    const std::string problem = problemOf(vehicles_[vehicle]);
    if (problem.empty() || result.state == PairState::kUnusable) continue;
    result.state = PairState::kUnusable;
    result.reason = "the map of " + vehicles_[vehicle].name + " cannot be used: " + problem;
  }
  if (result.state == PairState::kUnusable) return decision;
  if (pair.separated) {
    result.state = PairState::kSeparated;
    result.reason = "separated by the user";
    return decision;
  }
  explain(joint, pair, decision);
  if (result.state == PairState::kJoined) compare(joint, pair, decision);
  if (result.state == PairState::kJoined) compareOther(joint, pair, decision);
  if (result.state == PairState::kNoOverlap && guessOf(pair)) joinAsGiven(joint, pair, decision);
  return decision;
}

/// Whether the common places have one explanation.
void MapMerger::explain(const JointMap& joint, const Pair& pair, Decision& decision) const {
  const std::vector<Loop>& loops = pair.loops;
  ConsistentLoops consistency;
  for (const Loop& loop : loops) consistency.add(graphEdgeOf(loop), joint.chain());
  const Explanations found = consistency.explain();
  for (const std::size_t number : found.first) decision.loops.push_back(loops[number]);
  for (const std::size_t number : found.second) decision.others.push_back(loops[number]);
  PairResult& result = decision.result;
  result.found = loops.size();
  result.first = found.first.size();
  result.second = found.second.size();
  result.places = placesOf(joint, pair, decision.loops);
  if (loops.empty()) {
    result.reason = "no place of one map was found in the other";
  } else if (result.first < config_.min_loops) {
    result.reason = tooFew(result, config_);
  } else if (static_cast<double>(result.second) > kSimilar * static_cast<double>(result.first)) {
    result.state = PairState::kAmbiguous;
    result.reason =
        text(result.first, " matches say one thing, and ") + text(result.second, " say another");
  } else {
    result.state = PairState::kJoined;
  }
}

/// Number of places, far apart from each other, where the queries of the loops are in the map of
/// the first vehicle of the pair. A vehicle that stayed within this distance was at one place only,
/// wherever the other one has seen the same.
std::size_t MapMerger::placesOf(const JointMap& joint, const Pair& pair,
                                const std::vector<Loop>& loops) const {
  std::vector<Eigen::Vector2d> points;
  for (const Loop& loop : loops) {
    const bool is_own = joint.parts()[pair.a].contains(loop.query);
    const Pose2 query =
        is_own ? joint.poseOf(loop.query) : joint.poseOf(loop.anchor) * loop.anchor_T_query.mean;
    points.push_back(query.translation());
  }
  const std::size_t places = countFarPlaces(points, config_.place_m);
  const double way = std::min(joint.extentOf(pair.a), joint.extentOf(pair.b));
  return way < config_.place_m ? std::min<std::size_t>(places, 1) : places;
}

/// Joins the two maps for a trial and compares all that both vehicles have seen.
void MapMerger::compare(JointMap& joint, const Pair& pair, Decision& decision) {
  PairResult& result = decision.result;
  decision.poses = joinedByLoops(joint, pair.a, pair.b, decision.loops);
  Overlap overlap = compareOverlap(joint, matcher_, decision.poses, pair.a, pair.b, memory_);
  const Overlap other = compareOverlap(joint, matcher_, decision.poses, pair.b, pair.a, memory_);
  decision.whole =
      (overlap.fittingShare() >= config_.min_whole &&
       joint.extentOf(pair.b) >= config_.min_whole_m) ||
      (other.fittingShare() >= config_.min_whole && joint.extentOf(pair.a) >= config_.min_whole_m);
  overlap.add(other);
  decision.refined = overlap.agreeing;
  result.compared = overlap.compared;
  result.contradicting = overlap.contradicting;
  result.longest_contradiction_m = overlap.longest_contradiction_m;
  decision.poses = joinedByLoops(joint, pair.a, pair.b, decision.loops, decision.refined);
  result.differing_wall_m =
      longestContradictingWall(joint, decision.poses, decision.refined, pair.a, pair.b);
  const double agreeing = overlap.compared == 0 ? 0.0
                                                : 1.0 - static_cast<double>(overlap.contradicting) /
                                                            static_cast<double>(overlap.compared);
  result.confidence = agreeing * (1.0 - std::pow(0.5, static_cast<double>(result.places)));
  if (agreeing < config_.min_agreement) {
    result.reason =
        text(overlap.contradicting, " of ") + text(overlap.compared, " common scans do not fit");
  } else if (overlap.longest_contradiction_m > config_.max_contradiction_m) {
    result.reason = "the maps differ along " + meters(overlap.longest_contradiction_m) + " of way";
  } else if (result.places > 0 && result.places < config_.min_places && !decision.whole) {
    result.state = PairState::kNoOverlap;
    result.reason = tooFew(result, config_);
    return;
  } else if (result.differing_wall_m > (result.places < config_.min_places
                                            ? config_.max_differing_wall_in_room_m
                                            : config_.max_differing_wall_m)) {
    result.reason = "a wall of " + meters(result.differing_wall_m) + " is only in one of the maps";
  } else {
    result.reason = text(result.first, " matches at ") + text(result.places, " places");
    return;
  }
  result.state = PairState::kContradicted;
}

/// A room that looks like another one gives more matches than a door through which the right room
/// is seen. So the second explanation must be wrong by what the vehicles saw, not only smaller.
void MapMerger::compareOther(JointMap& joint, const Pair& pair, Decision& decision) {
  if (decision.others.size() < config_.min_loops) return;
  Decision other;
  other.loops = decision.others;
  other.result.state = PairState::kJoined;
  compare(joint, pair, other);
  if (other.result.state == PairState::kContradicted) return;
  decision.result.state = PairState::kAmbiguous;
  decision.result.reason = text(decision.result.first, " matches say one thing, and ") +
                           text(decision.result.second, " another that is possible, too");
}

/// Nothing was found in common: the maps are joined as was said, unless they contradict it.
void MapMerger::joinAsGiven(JointMap& joint, const Pair& pair, Decision& decision) {
  PairResult& result = decision.result;
  const Loop given = givenLoop(joint, pair.a, pair.b, *guessOf(pair));
  decision.loops = {given};
  result.places = 0;
  compare(joint, pair, decision);
  if (result.compared > 0 && result.state == PairState::kContradicted) {
    result.reason = "the given pose is wrong: " + result.reason;
    return;
  }
  result.state = PairState::kGiven;
  result.reason = "as given; no common place was found";
}

void MapMerger::optimizeAll(const JointMap& joint, std::vector<Decision>& decisions,
                            MergeResult& result) const {
  for (bool changed = true; changed;) {
    changed = false;
    JointSolution solution(joint);
    std::vector<std::size_t> order(decisions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return decisions[a].result.confidence > decisions[b].result.confidence;
    });
    for (const std::size_t i : order) {
      const Decision& decision = decisions[i];
      if (!decision.result.isJoined()) continue;
      solution.join(i, decision.result.a, decision.result.b, decision.loops, decision.refined);
    }
    solution.solve();
    for (const std::size_t contradicted : solution.contradicted()) {
      PairResult& pair = decisions[contradicted].result;
      pair.state = PairState::kUndone;
      pair.reason = "the map of all vehicles contradicts it";
      changed = true;
      break;  // the others may be right without this one
    }
    result.graph = solution.graph();
    result.group = solution.groups();
    result.loops_between = solution.loopsBetween();
  }
}

/// The poses in `world`.
void MapMerger::place(const JointMap& joint, MergeResult& result) const {
  for (std::size_t v = 0; v < vehicles_.size(); ++v) {
    const std::optional<Pose2>& given = vehicles_[result.group[v]].world_T_map;
    const JointMap::Part& part = joint.parts()[v];
    std::vector<Pose2> poses;
    for (std::size_t i = part.first; i < part.last; ++i) {
      Pose2& pose = result.graph.vertices[i].pose;
      if (given) pose = *given * pose;
      poses.push_back(pose);
    }
    const bool empty = poses.empty();
    result.world_T_map.push_back(empty ? given.value_or(Pose2())
                                       : poses.back() * vehicles_[v].poses.back().inverse());
    result.poses.push_back(std::move(poses));
  }
  for (PairResult& pair : result.pairs) {
    if (pair.isJoined())
      pair.a_T_b = result.world_T_map[pair.a].between(result.world_T_map[pair.b]);
  }
}

}  // namespace kestrel
