// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// Something to mark in a GeoTIFF.
struct GeotiffMark {
  /// victim: red circle; hazard: orange diamond; qr: blue circle; other: gray circle.
  enum class Kind { kVictim, kHazard, kQr, kOther };

  Kind kind = Kind::kOther;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< in the map, m
  std::string text;                                    ///< a few characters
};

struct GeotiffContent {
  MapSnapshot map;
  std::vector<Pose2> path;  ///< of the vehicle; begins with the arrow of the start
  std::vector<GeotiffMark> marks;
  std::string title;         ///< in the upper left corner
  bool checkerboard = true;  ///< of the unexplored area, 1 m
  bool grid = true;          ///< of the explored area, 0.5 m
};

/// Writes NAME.tif and the world file NAME.tfw, with the colors of the RoboCup Rescue league, as
/// hector_geotiff does: up is x of the map, and right is -y. In geographic terms north is x and
/// east is -y. Throws std::runtime_error.
void writeGeotiff(const std::string& name, const GeotiffContent& content);

}  // namespace kestrel
