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
  kPartition   ///< a wall of 60 % of the depth divides the room
};

const char* toString(OfficeChange change);

/// A corridor with furnished rooms on both sides; everything is random. The flight visits all
/// rooms. `route`: another number begins elsewhere, and takes another order and another heading.
/// `rooms`: on both sides together; 90 make a flight of 1 km.
Place randomOffice(std::uint64_t seed, OfficeChange change = OfficeChange::kNone,
                   std::uint64_t route = 0, std::size_t rooms = 6);

}  // namespace kestrel
