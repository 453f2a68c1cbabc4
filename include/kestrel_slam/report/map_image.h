// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// A map as a gray PNG with the gray values of map_server. The first row has the largest y.
struct MapImage {
  std::string png;  ///< the bytes of the file
  int width = 0;
  int height = 0;
  int cells_per_pixel = 1;  ///< greater than 1 if the map is too large for an image
};

/// Gray values of the cells; by default those of map_server.
struct MapGrays {
  unsigned char free = 254, unknown = 205, occupied = 0;
};

unsigned char grayOf(std::int8_t cell, const MapGrays& grays);

/// Renders a map; the result is empty for an empty map. If several cells share a pixel, it is
/// occupied if one of them is occupied, else free if one is free, else unknown. Throws
/// std::runtime_error if the image cannot be created.
MapImage renderMap(const MapSnapshot& map, int max_side_pixels = 8192,
                   const MapGrays& grays = MapGrays());

/// The box around the walls, m, without the few that lie far outside. Empty without walls.
std::optional<Eigen::AlignedBox2d> wallBox(const MapSnapshot& map);

/// Encodes `bytes` in base64, for data URLs.
std::string base64(const std::string& bytes);

}  // namespace kestrel
