// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/merging/map_merger.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// What a simulated vehicle has mapped.
struct SimulatedMap {
  VehicleMap map;
  Pose2 world_T_map;          ///< the truth at the start of its flight
  std::vector<Pose2> truths;  ///< world_T_base of the keyframes

  double error() const;  ///< the largest one of a keyframe, m
};

/// Two vehicles that fly at different heights.
struct PairAtHeights {
  std::string where;   ///< and what differs between their buildings
  std::string flying;  ///< how they fly
  const SimulatedMap *a = nullptr, *b = nullptr;
};

/// Vehicles that fly at different heights in simulated buildings whose doors have lintels: an
/// office (officeWithDoors()) and the place `doors`, each as it is and with changes.
class FlightsAtHeights {
 public:
  FlightsAtHeights(std::uint64_t seed, const SlamConfig& config);
  const std::vector<PairAtHeights>& pairs() const { return pairs_; }

 private:
  void addOffice(std::uint64_t seed, const SlamConfig& config);
  void addFourRooms(std::uint64_t seed, const SlamConfig& config);

  std::vector<std::unique_ptr<SimulatedMap>> maps_;
  std::vector<PairAtHeights> pairs_;
};

/// How two maps were merged.
struct MergedPair {
  PairResult result;
  double error_m = 0.0;  ///< of the pose of one map in the other, if they were joined
};

/// Merges a pair as it is, and as if the heights were not known.
struct MergedAtHeights {
  MergedPair with, without;
};
MergedAtHeights mergeAtHeights(const PairAtHeights& pair, const SlamConfig& config);

}  // namespace kestrel
