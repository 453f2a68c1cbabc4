// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {

/// What is different in one room of an office, compared with the office of the same seed.
enum class OfficeChange {
  kNone,
  kFurniture,  ///< the furniture of the room stands elsewhere; it is the same building
  kShallow,    ///< the room is 1.2 m less deep
  kDeep,       ///< the room is 1.2 m deeper
  kPartition,  ///< a wall of 60 % of the depth divides the room
  kDoor        ///< officeWithDoors(): the door to the next room is a wall
};

const char* toString(OfficeChange change);

/// A corridor with furnished rooms on both sides; everything is random. The flight visits all
/// rooms. `route`: another number begins elsewhere, and takes another order and another heading.
/// `rooms`: on both sides together; 90 make a flight of 1 km.
Place randomOffice(std::uint64_t seed, OfficeChange change = OfficeChange::kNone,
                   std::uint64_t route = 0, std::size_t rooms = 6);

/// Heights of a flight in the rooms, m over the floor: random ones between them.
struct FlightHeights {
  double lowest = 1.0, highest = 1.0;
};

/// The same office with lintels above the doors, and doors between the rooms, which the flight does
/// not pass. It is low at the doors, and hovers at two heights in every room.
Place officeWithDoors(std::uint64_t seed, OfficeChange change, std::uint64_t route,
                      const FlightHeights& heights);

}  // namespace kestrel
