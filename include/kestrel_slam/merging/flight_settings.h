// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/merging/vehicle_map.h"

namespace kestrel {

/// What the map of this flight has in common with all its later states, and with no other flight.
std::string flightOf(const VehicleMap& map);

/// What a user has said about the flights of a mission, and where `world` is. A vehicle that is
/// restarted begins another flight under its old name: what was said about its first flight is not
/// true for it.
struct FlightSettings {
  struct Start {
    std::string name;  ///< of the vehicle, when the user said it
    Pose2 world_T_map;
  };
  std::map<std::string, Start> starts;                      ///< by flight
  std::set<std::pair<std::string, std::string>> separated;  ///< flights
  std::vector<std::string> order;                           ///< flights, as they were merged

  /// Whether any of these flights was merged before. If not, it is another mission.
  bool isOf(const std::vector<VehicleMap>& vehicles) const;
  /// Flights that were merged before come first, in the order of then: `world` is the map of the
  /// first one.
  void sort(std::vector<VehicleMap>& vehicles) const;

  /// A start that is said again and again is that of the flight which had the name at first.
  void start(const VehicleMap& vehicle, const Pose2& world_T_map);
  /// The user wants this flight to be joined here.
  void join(const VehicleMap& vehicle, const Pose2& world_T_map);
  void separate(const VehicleMap& a, const VehicleMap& b);
  bool areSeparated(const VehicleMap& a, const VehicleMap& b) const;

  /// Gives the vehicles their starts.
  void apply(std::vector<VehicleMap>& vehicles) const;
};

}  // namespace kestrel
