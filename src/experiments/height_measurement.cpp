// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/height_measurement.h"

#include <algorithm>
#include <utility>

#include "kestrel_slam/experiments/merging_measurement.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {
namespace {

/// A way of flying.
struct Flying {
  const char* name;
  FlightHeights heights;
};

/// Below and above the lintels, at both, and anything.
std::vector<Flying> waysOfFlying(std::uint64_t seed) {
  constexpr double kLowest = 0.8, kHighest = 2.5;  // m
  Random random(seed);
  const double low = random.uniform(kLowest, 1.6), high = random.uniform(2.2, kHighest);
  return {{"low", {low, low}}, {"high", {high, high}}, {"changing", {kLowest, kHighest}}};
}

SimulatedMap mapOf(const Place& place, std::uint64_t seed, const SlamConfig& config) {
  VehicleModel vehicle = quadrotorWith("utm30lx");
  vehicle.laser->rate_hz = 10.0;  // enough for a slow flight
  SimulatedRecording recording(place, vehicle, seed);
  const MappedVehicle mapped = mapVehicle("uav" + std::to_string(seed), recording, config, {});
  SimulatedMap result{mapped.map, {}, {}};
  for (const LocalKeyframe& keyframe : mapped.map.keyframes)
    result.truths.push_back(truePose(recording.motion(), keyframe.keyframe->stamp));
  if (!result.truths.empty())
    result.world_T_map = result.truths.front() * mapped.map.poses.front().inverse();
  return result;
}

/// The place `doors`; a door of the room in which its flights begin is a wall.
Place withoutDoor(Place rooms, bool along_x) {
  constexpr double kWidth = 1.4, kThickness = 0.3;
  const Eigen::Vector2d door = along_x ? Eigen::Vector2d(-2.8, 0.0) : Eigen::Vector2d(0.0, -2.8);
  const double height = rooms.parts.ceiling_m;
  rooms.parts.boxes.push_back(
      {{door.x(), door.y(), 0.5 * height},
       {along_x ? kWidth : kThickness, along_x ? kThickness : kWidth, height},
       0.0,
       Material::kMatt});
  return rooms;
}

VehicleMap withoutHeights(VehicleMap map) {
  for (LocalKeyframe& entry : map.keyframes) {
    auto keyframe = std::make_shared<Keyframe>(*entry.keyframe);
    keyframe->height = ScanHeight();
    entry.keyframe = std::move(keyframe);
  }
  return map;
}

MergedPair mergedBy(MapMerger& merger, const PairAtHeights& pair) {
  MergedPair merged;
  merged.result = merger.merge().pairs.front();
  const Pose2 truth = pair.a->world_T_map.between(pair.b->world_T_map);
  if (merged.result.isJoined()) merged.error_m = truth.between(merged.result.a_T_b).distance();
  return merged;
}

}  // namespace

double SimulatedMap::error() const {
  double largest = 0.0;
  for (std::size_t i = 0; i < truths.size(); ++i)
    largest = std::max(largest, truths[i].between(world_T_map * map.poses[i]).distance());
  return largest;
}

FlightsAtHeights::FlightsAtHeights(std::uint64_t seed, const SlamConfig& config) {
  addOffice(seed, config);
  addFourRooms(seed, config);
}

void FlightsAtHeights::addOffice(std::uint64_t seed, const SlamConfig& config) {
  const std::vector<Flying> ways = waysOfFlying(seed);
  const std::size_t first = maps_.size();
  const auto fly = [&](OfficeChange change, std::uint64_t route, const Flying& way) {
    const Place office = officeWithDoors(seed, change, route, way.heights);
    maps_.push_back(
        std::make_unique<SimulatedMap>(mapOf(office, 100 * seed + maps_.size(), config)));
    return maps_.back().get();
  };
  for (const Flying& way : ways) fly(OfficeChange::kNone, 1, way);
  for (const OfficeChange change :
       {OfficeChange::kNone, OfficeChange::kDoor, OfficeChange::kPartition}) {
    for (const Flying& way : ways) {
      const SimulatedMap* const other = fly(change, 2, way);
      for (std::size_t i = 0; i < ways.size(); ++i) {
        const std::string flying = std::string(ways[i].name) + ", " + way.name;
        pairs_.push_back(
            {std::string("office, ") + toString(change), flying, maps_[first + i].get(), other});
      }
    }
  }
}

/// As the vehicles of scripts/benchmark_fleet: one flies through all rooms, the others at random.
void FlightsAtHeights::addFourRooms(std::uint64_t seed, const SlamConfig& config) {
  constexpr double kDuration = 90.0;  // s
  constexpr std::size_t kVehicles = 4;
  const Place rooms = place("doors");
  const auto fly = [&](Place where, std::size_t number) {
    const std::uint64_t flight = 100 * seed + maps_.size();
    if (number > 0) where.plan = randomPlan(where, kDuration, flight);
    maps_.push_back(std::make_unique<SimulatedMap>(mapOf(where, flight, config)));
    return maps_.back().get();
  };
  std::vector<const SimulatedMap*> vehicles;
  for (std::size_t b = 0; b < kVehicles; ++b) {
    vehicles.push_back(fly(rooms, b));
    for (std::size_t a = 0; a < b; ++a)
      pairs_.push_back({"four rooms, the same", "random", vehicles[a], vehicles[b]});
  }
  for (const bool along_x : {false, true}) {
    const SimulatedMap* const twin = fly(withoutDoor(rooms, along_x), 1);
    for (const SimulatedMap* const vehicle : vehicles)
      pairs_.push_back({"four rooms, no door", "random", vehicle, twin});
  }
}

MergedAtHeights mergeAtHeights(const PairAtHeights& pair, const SlamConfig& config) {
  MapMerger merger(config.mapper, config.loops);
  MergedAtHeights merged;
  merger.update(withoutHeights(pair.a->map));
  merger.update(withoutHeights(pair.b->map));
  merged.without = mergedBy(merger, pair);
  merger.update(pair.a->map);  // searched only once
  merger.update(pair.b->map);
  merged.with = mergedBy(merger, pair);
  return merged;
}

}  // namespace kestrel
