// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/graph/pairwise_consistency.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/merging/common_places.h"
#include "kestrel_slam/merging/overlap.h"
#include "kestrel_slam/merging/search_memory.h"
#include "kestrel_slam/merging/vehicle_map.h"

namespace kestrel {

/// Parameters of merging. All defaults are defined here.
struct MergingConfig {
  std::size_t max_queries = 64;  ///< queries of one map that are searched for in another one
  std::size_t min_loops = 3;     ///< that agree about how two maps lie,
  std::size_t min_places = 2;    ///< at so many places
  double place_m = 5.0;          ///< that are this far apart.
  /// Small buildings have no such places. There, at least this share of the keyframes of one
  /// vehicle must be known in the other map and fit, on a way that is this long.
  double min_whole = 0.8, min_whole_m = 3.0;
  double min_agreement = 0.7;        ///< share of the keyframes in both maps that fit
  double max_contradiction_m = 2.0;  ///< length of the way along which none fits
  /// Length of a wall where the other vehicle saw free space. Less is allowed where all common
  /// places are in one room, because rooms look alike.
  double max_differing_wall_m = 1.0, max_differing_wall_in_room_m = 0.8;
};

/// How two maps belong together.
enum class PairState {
  kJoined,        ///< the scans show it
  kGiven,         ///< only by the poses that were given
  kNoOverlap,     ///< no common places, or too few, were found
  kAmbiguous,     ///< the common places have two explanations
  kContradicted,  ///< common places were found, but the maps differ where both are known
  kUndone,        ///< it was joined, and the map of all vehicles contradicts it
  kSeparated,     ///< the user has separated them
  kUnusable       ///< one of the maps cannot be used
};

const char* toString(PairState state);

/// What was found between two vehicles, and why they are joined or not.
struct PairResult {
  std::size_t a = 0, b = 0;  ///< vehicles
  PairState state = PairState::kNoOverlap;
  std::string reason;
  /// 0 to 1: the share of the common keyframes that agree, times 1 - 2^-n for n places.
  double confidence = 0.0;
  std::size_t searched = 0;                     ///< queries
  std::size_t found = 0;                        ///< common places that were found and verified
  std::size_t first = 0;                        ///< of these, those of the largest consistent set
  std::size_t second = 0;                       ///< those of the largest set that contradicts it
  std::size_t places = 0;                       ///< places of the first set that are far apart
  std::size_t compared = 0, contradicting = 0;  ///< keyframes that are known in the other map
  double longest_contradiction_m = 0.0;
  double differing_wall_m = 0.0;  ///< the longest wall of one map that is free in the other
  Pose2 a_T_b;                    ///< of the two maps, if joined

  bool isJoined() const { return state == PairState::kJoined || state == PairState::kGiven; }
};

/// The maps of all vehicles, as far as they belong together.
struct MergeResult {
  std::vector<PairResult> pairs;
  /// For each vehicle, the first vehicle of its group. Groups are not placed relative to each
  /// other.
  std::vector<std::size_t> group;
  /// For each vehicle, world_T_base of its keyframes. `world` is the map of the first vehicle of
  /// the group, or where it was said to be.
  std::vector<std::vector<Pose2>> poses;
  std::vector<Pose2> world_T_map;  ///< for each vehicle, where it flies now
  PoseGraph graph;                 ///< of all vehicles, one after the other; loops between them too
  std::size_t loops_between = 0;   ///< edges of `graph` between vehicles

  /// Vehicles in the largest group.
  std::size_t largestGroup() const;
};

/// Of the optimization of the graph of all vehicles.
OptimizerOptions jointOptions();

/// Merges the maps of any number of vehicles. Deterministic: no clock, no thread. The result
/// depends only on the maps, not on what they were before. Maps may grow: what was searched for
/// before is in memory().
///
/// Two maps are joined if enough places were found in both (each verified as a loop is), if these
/// agree about how the maps lie [Mangelson 2018], if no second set of places says something else,
/// and if what both vehicles have seen does not differ.
class MapMerger {
 public:
  MapMerger(const MapperConfig& mapper, const LoopConfig& loops, const MergingConfig& config = {});

  /// Adds a vehicle, or replaces its map by a newer one. Returns its number.
  std::size_t update(VehicleMap map);

  /// Never joins two vehicles by themselves; they may still be joined through a third one.
  void separate(std::size_t a, std::size_t b);

  MergeResult merge();

  const std::vector<VehicleMap>& vehicles() const { return vehicles_; }
  SearchMemory& memory() { return memory_; }

 private:
  struct Pair {
    std::size_t a = 0, b = 0;
    bool separated = false;
    std::size_t searched = 0;  ///< queries
    std::vector<Loop> loops;   ///< verified ones, indices of the joint map
  };
  struct Decision {
    PairResult result;
    std::vector<Loop> loops;   ///< of the first set, indices of the joint map
    std::vector<Loop> others;  ///< of the second set
    std::vector<Loop> refined;
    std::vector<PoseVertex> poses;  ///< of the joint map, with this pair joined
    bool whole = false;             ///< one of the maps fits as a whole into the other one
  };

  Pair& pairOf(std::size_t a, std::size_t b);
  std::optional<Pose2> guessOf(const Pair& pair) const;
  void search(JointMap& joint, Pair& pair);
  void searchQueries(JointMap& joint, Pair& pair, bool query_in_a);
  std::vector<LoopQuery> chosen(const std::vector<LoopQuery>& queries) const;
  Decision decide(JointMap& joint, const Pair& pair);
  void explain(const JointMap& joint, const Pair& pair, Decision& decision) const;
  std::size_t placesOf(const JointMap& joint, const Pair& pair,
                       const std::vector<Loop>& loops) const;
  void compare(JointMap& joint, const Pair& pair, Decision& decision);
  void compareOther(JointMap& joint, const Pair& pair, Decision& decision);
  void joinAsGiven(JointMap& joint, const Pair& pair, Decision& decision);
  void optimizeAll(const JointMap& joint, std::vector<Decision>& decisions,
                   MergeResult& result) const;
  void place(const JointMap& joint, MergeResult& result) const;

  MapperConfig mapper_;
  LoopConfig loop_config_;
  MergingConfig config_;
  CommonPlaces places_;
  LoopMatcher matcher_;
  SearchMemory memory_;
  std::vector<VehicleMap> vehicles_;
  std::vector<Pair> pairs_;  ///< (0, 1), (0, 2), (1, 2), (0, 3), ...
};

}  // namespace kestrel
