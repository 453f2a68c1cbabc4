// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/wall_agreement.h"

namespace kestrel {

/// Which walls of the map a beam can pass through.
enum class CrossedWalls {
  kAll,
  /// Those that go on to both sides of the beam. A beam may pass the end of a wall, the jamb of a
  /// door, or the leg of a chair, which it hits with a slightly different pose.
  kBetweenEnds
};

/// compareWalls with this kind of walls. Loops are judged with all of them: their limit was
/// measured so.
WallAgreement compareWalls(const Submap& map, const std::vector<ScanInMap>& scans,
                           std::size_t most_beams, CrossedWalls crossed);

}  // namespace kestrel
