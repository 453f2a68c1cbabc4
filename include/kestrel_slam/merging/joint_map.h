// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/odometry_chain.h"
#include "kestrel_slam/merging/search_memory.h"
#include "kestrel_slam/merging/vehicle_map.h"

namespace kestrel {

/// Keyframes, places and graph of several vehicles with common indices: all of the first vehicle
/// come first, then all of the second one, and so on.
class JointMap {
 public:
  /// The keyframes and places of one vehicle: [first, last).
  struct Part {
    std::size_t first = 0, last = 0;
    std::size_t first_place = 0, last_place = 0;
    bool contains(std::size_t keyframe) const { return keyframe >= first && keyframe < last; }
  };

  JointMap(const MapperConfig& config, const std::vector<const VehicleMap*>& vehicles);

  const std::vector<Part>& parts() const { return parts_; }
  /// With their poses in the local frames of the mappers, which are also those of the places.
  const std::vector<LocalKeyframe>& keyframes() const { return keyframes_; }
  /// The pose of a keyframe in the map of its vehicle.
  const Pose2& poseOf(std::size_t keyframe) const { return graph_.vertices[keyframe].pose; }
  /// map_T_local at a place.
  Pose2 mapTLocal(std::size_t place) const;
  const KnownPlace& place(std::size_t number) const { return places_.all()[number]; }
  /// The grid of a place, in its local frame. Valid until the next call.
  const Submap& mapOf(std::size_t place) { return places_.mapOf(place, keyframes_); }
  /// The graphs of the vehicles side by side, each in its own map.
  const PoseGraph& graph() const { return graph_; }
  /// The corrected poses of each vehicle with the noise of its odometry.
  const OdometryChain& chain() const { return chain_; }
  /// About the largest distance of two keyframes of the part, m.
  double extentOf(std::size_t part) const;
  /// The part that a keyframe belongs to.
  std::size_t partOf(std::size_t keyframe) const;

  /// Hashes of the scans and local poses of some keyframes, and of those of a place.
  SearchMemory::Key keyOf(std::size_t first, std::size_t last) const;
  const SearchMemory::Key& keyOf(std::size_t place) const { return place_keys_[place]; }

 private:
  void add(const VehicleMap& vehicle);
  void addChain();
  std::size_t farthestFrom(std::size_t keyframe, const Part& part) const;

  std::vector<Part> parts_;
  std::vector<LocalKeyframe> keyframes_;
  Places places_;
  std::vector<SearchMemory::Key> keyframe_keys_, place_keys_;
  PoseGraph graph_;
  OdometryChain chain_;
};

}  // namespace kestrel
