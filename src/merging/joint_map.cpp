// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/joint_map.h"

#include <algorithm>
#include <utility>

namespace kestrel {

namespace {

/// Memory of the grids: every vehicle is searched for in all places of all others.
constexpr std::size_t kGridBytes = 300'000'000;

SearchMemory::Key keyOfKeyframe(const LocalKeyframe& entry) {
  KeyMaker key;
  key.add(entry.keyframe->scan.bytes());
  for (const double value : {entry.local_T_base.x, entry.local_T_base.y, entry.local_T_base.yaw})
    key.add(value);
  key.add(static_cast<std::uint64_t>(entry.keyframe->new_view));
  return key.key();
}

}  // namespace

JointMap::JointMap(const MapperConfig& config, const std::vector<const VehicleMap*>& vehicles)
    : places_(config, kGridBytes) {
  for (const VehicleMap* vehicle : vehicles) add(*vehicle);
  addChain();
}

void JointMap::add(const VehicleMap& vehicle) {
  Part part;
  part.first = keyframes_.size();
  part.first_place = places_.all().size();
  for (const LocalKeyframe& keyframe : vehicle.keyframes) {
    keyframes_.push_back(keyframe);
    keyframe_keys_.push_back(keyOfKeyframe(keyframe));
  }
  for (const Pose2& pose : vehicle.poses) graph_.vertices.push_back({pose});
  for (const KnownPlace& place : vehicle.places) {
    places_.add(place.submap, part.first + place.first, part.first + place.last);
    place_keys_.push_back(keyOf(part.first + place.first, part.first + place.last));
  }
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
    edge.measured = poseOf(edge.from).between(poseOf(edge.to));
    corrected.edges.push_back(edge);
  }
  chain_.grow(corrected);
}

SearchMemory::Key JointMap::keyOf(std::size_t first, std::size_t last) const {
  KeyMaker key;
  for (std::size_t i = first; i < last; ++i) key.add(keyframe_keys_[i]);
  return key.key();
}

Pose2 JointMap::mapTLocal(std::size_t place) const {
  const KnownPlace& known = places_.all()[place];
  const std::size_t middle = (known.first + known.last) / 2;
  return poseOf(middle) * keyframes_[middle].local_T_base.inverse();
}

std::size_t JointMap::farthestFrom(std::size_t keyframe, const Part& part) const {
  std::size_t farthest = keyframe;
  for (std::size_t i = part.first; i < part.last; ++i) {
    if (poseOf(keyframe).between(poseOf(i)).distance() >
        poseOf(keyframe).between(poseOf(farthest)).distance())
      farthest = i;
  }
  return farthest;
}

double JointMap::extentOf(std::size_t part) const {
  if (parts_[part].first == parts_[part].last) return 0.0;
  const std::size_t end = farthestFrom(parts_[part].first, parts_[part]);
  return poseOf(end).between(poseOf(farthestFrom(end, parts_[part]))).distance();
}

std::size_t JointMap::partOf(std::size_t keyframe) const {
  std::size_t part = 0;
  while (!parts_[part].contains(keyframe)) ++part;
  return part;
}

}  // namespace kestrel
