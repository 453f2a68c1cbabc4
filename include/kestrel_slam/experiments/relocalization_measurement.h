// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/graph/relocalizer.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper_config.h"

namespace kestrel {

/// A scan of a recording, and its pose in the optimized trajectory of the whole recording.
struct PlacedScan {
  PlanarScan scan;
  Pose2 pose;             ///< map_T_base
  bool inserted = false;  ///< into the map
  bool new_view = false;  ///< see OccupancyGrid::insert
};

/// All scans of a recording, mapped with loops. Throws std::runtime_error if it cannot be read.
std::vector<PlacedScan> placeScans(const std::string& path);

struct RelocalizationTrial {
  double stamp = 0.0;  ///< of the scan
  RelocalizationAnswer answer;
  /// This share of the hits of the scan is in the known part of the map at the true pose: kInMap.
  /// With motion: at the first and at the last scan.
  bool in_map = false;
  double known = 0.0, fit = 0.0;          ///< at the true pose
  double error_m = 0.0, error_deg = 0.0;  ///< of the best hypothesis
  double travel_m = 0.0;                  ///< until the answer
  std::vector<double> seconds;            ///< processor time of each search
  std::size_t memory_bytes = 0;           ///< above the map

  bool isFound() const { return answer.state == RelocalizationState::kFound; }
  bool isRight() const;
};

constexpr double kInMap = 0.6;

/// A map in which vehicles are searched for.
class RelocalizationMap {
 public:
  /// Of the inserted scans [first, last).
  RelocalizationMap(const std::vector<PlacedScan>& scans, std::size_t first, std::size_t last);

  const Submap& map() const { return map_; }
  const GlobalMap& global() const { return global_; }

  /// Searches for one scan alone.
  RelocalizationTrial locate(const PlacedScan& scan) const;
  /// Searches while the vehicle moves on from the scan `first`, until it is found or has moved by
  /// `travel_m`. A new mapper measures the motion with the laser.
  RelocalizationTrial follow(const std::vector<PlacedScan>& scans, std::size_t first,
                             double travel_m) const;

 private:
  void compare(const PlacedScan& scan, RelocalizationTrial& trial) const;

  MapperConfig config_;
  Submap map_;
  GlobalMap global_;
};

}  // namespace kestrel
