// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/flight_settings.h"

#include <algorithm>
#include <cstdio>

#include "kestrel_slam/merging/search_memory.h"

namespace kestrel {
namespace {

std::pair<std::string, std::string> pairOf(const VehicleMap& a, const VehicleMap& b) {
  return std::minmax(flightOf(a), flightOf(b));
}

}  // namespace

std::string flightOf(const VehicleMap& map) {
  if (map.keyframes.empty()) return "";
  const Keyframe& first = *map.keyframes.front().keyframe;
  KeyMaker maker;
  maker.add(first.stamp);
  maker.add(first.scan.bytes());
  const SearchMemory::Key key = maker.key();
  char text[40];
  std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(key[0]),
                static_cast<unsigned long long>(key[1]));
  return text;
}

bool FlightSettings::isOf(const std::vector<VehicleMap>& vehicles) const {
  return std::any_of(vehicles.begin(), vehicles.end(), [&](const VehicleMap& vehicle) {
    return std::find(order.begin(), order.end(), flightOf(vehicle)) != order.end();
  });
}

void FlightSettings::sort(std::vector<VehicleMap>& vehicles) const {
  const auto rank = [&](const VehicleMap& vehicle) {
    return std::find(order.begin(), order.end(), flightOf(vehicle)) - order.begin();
  };
  std::stable_sort(vehicles.begin(), vehicles.end(),
                   [&](const VehicleMap& a, const VehicleMap& b) { return rank(a) < rank(b); });
}

void FlightSettings::start(const VehicleMap& vehicle, const Pose2& world_T_map) {
  const bool is_known = std::any_of(starts.begin(), starts.end(), [&](const auto& entry) {
    return entry.second.name == vehicle.name && entry.second.world_T_map == world_T_map;
  });
  if (!is_known) starts[flightOf(vehicle)] = {vehicle.name, world_T_map};
}

void FlightSettings::join(const VehicleMap& vehicle, const Pose2& world_T_map) {
  const std::string flight = flightOf(vehicle);
  starts[flight] = {vehicle.name, world_T_map};
  for (auto at = separated.begin(); at != separated.end();)
    at = at->first == flight || at->second == flight ? separated.erase(at) : std::next(at);
}

void FlightSettings::separate(const VehicleMap& a, const VehicleMap& b) {
  separated.insert(pairOf(a, b));
}

bool FlightSettings::areSeparated(const VehicleMap& a, const VehicleMap& b) const {
  return separated.count(pairOf(a, b)) > 0;
}

void FlightSettings::apply(std::vector<VehicleMap>& vehicles) const {
  for (VehicleMap& vehicle : vehicles) {
    const auto found = starts.find(flightOf(vehicle));
    if (found != starts.end()) vehicle.world_T_map = found->second.world_T_map;
  }
}

}  // namespace kestrel
