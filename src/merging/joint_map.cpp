// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/joint_map.h"

#include <algorithm>
#include <utility>

namespace kestrel {

JointMap::JointMap(const MapperConfig& config, const std::vector<const VehicleMap*>& vehicles)
    : places_(config) {
  for (const VehicleMap* vehicle : vehicles) add(*vehicle);
  addChain();
}

void JointMap::add(const VehicleMap& vehicle) {
  Part part;
  part.first = keyframes_.size();
  part.first_place = places_.all().size();
  for (const LocalKeyframe& keyframe : vehicle.keyframes) {
    keyframes_.push_back(keyframe);
    graph_.vertices.push_back({keyframe.local_T_base});
  }
  for (const KnownPlace& place : vehicle.places)
    places_.add(place.submap, part.first + place.first, part.first + place.last);
  for (PoseEdge edge : vehicle.edges) {
    edge.from += part.first;
    edge.to += part.first;
    graph_.edges.push_back(edge);
  }
  part.last = keyframes_.size();
  part.last_place = places_.all().size();
  parts_.push_back(part);
}

/// The motions are those of the corrected map: the loops of a vehicle have made it exact.
void JointMap::addChain() {
  PoseGraph corrected;
  corrected.vertices = graph_.vertices;
  for (PoseEdge edge : graph_.edges) {
    if (edge.kind != EdgeKind::kOdometry || edge.to != edge.from + 1) continue;
    edge.measured = keyframes_[edge.from].local_T_base.between(keyframes_[edge.to].local_T_base);
    corrected.edges.push_back(edge);
  }
  chain_.grow(corrected);
}

double JointMap::extentOf(std::size_t part) const {
  double extent = 0.0;
  for (std::size_t i = parts_[part].first; i < parts_[part].last; ++i) {
    const Pose2 away =
        keyframes_[parts_[part].first].local_T_base.between(keyframes_[i].local_T_base);
    extent = std::max(extent, away.distance());
  }
  return extent;
}

std::size_t JointMap::partOf(std::size_t keyframe) const {
  std::size_t part = 0;
  while (!parts_[part].contains(keyframe)) ++part;
  return part;
}

}  // namespace kestrel
