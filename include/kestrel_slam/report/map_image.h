// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// A map as a gray PNG, upper row first, with the gray values of map_server.
struct MapImage {
  std::string png;  ///< the bytes of the file
  int width = 0;
  int height = 0;
  int cells_per_pixel = 1;  ///< more than 1 where the map is too large for an image
};

/// Empty for an empty map. Where cells share a pixel, an occupied one wins over a free one, and
/// that over an unknown one. Throws std::runtime_error where the image cannot be made.
MapImage renderMap(const MapSnapshot& map, int max_side_pixels = 8192);

/// `bytes` in base64, as a data URL needs them.
std::string base64(const std::string& bytes);

}  // namespace kestrel
