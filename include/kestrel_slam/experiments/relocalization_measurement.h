// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/experiments/kidnapping.h"
#include "kestrel_slam/graph/relocalizer.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/recording/trajectory.h"

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

/// A vehicle that was localized over many scans.
struct LocalizationTrial {
  Trajectory trajectory;             ///< of the scans with a known pose
  std::size_t scans = 0, lost = 0;   ///< lost: the pose was unknown; the scans before it was found
                                     ///< for the first time do not count
  std::size_t wrong = 0;             ///< the pose is farther than kRightM from the truth
  double mean_m = 0.0, max_m = 0.0;  ///< distance from the trajectory with loops
  double seconds = 0.0;              ///< processor time
  double mapping_seconds = 0.0;      ///< of mapping the same scans
};

/// A vehicle whose scans stayed away for some time.
struct GapTrial {
  std::size_t scans = 0, lost = 0;  ///< after the gap; lost: the pose was said to be unknown
  std::size_t wrong = 0;            ///< a pose farther than kRightM from the truth
};

/// A map in which vehicles are searched for.
class RelocalizationMap {
 public:
  /// Of the inserted scans [first, last). `scans` must outlive the object.
  RelocalizationMap(const std::vector<PlacedScan>& scans, std::size_t first, std::size_t last);

  const Submap& map() const { return map_; }
  const GlobalMap& global() const { return global_; }

  /// Whether the place of the scan is in the map: kInMap.
  bool isKnown(const PlacedScan& scan) const;
  /// Searches for one scan alone.
  RelocalizationTrial locate(const PlacedScan& scan) const;
  /// Searches while the vehicle moves on from the scan `first`, until it is found or has moved by
  /// `travel_m`. A new mapper measures the motion with the laser.
  RelocalizationTrial follow(const std::vector<PlacedScan>& scans, std::size_t first,
                             double travel_m) const;
  /// Localizes the scans [first, last), which begin with an unknown pose. `picture`: in the pgm
  /// file of the map, as any other program writes it.
  LocalizationTrial localize(const std::vector<PlacedScan>& scans, std::size_t first,
                             std::size_t last, bool picture) const;
  /// Follows the vehicle for a second from the scan `from`, covers the laser for `covered_s`, and
  /// goes on from the scan `to` for `travel_m`.
  KidnapTrial kidnap(const std::vector<PlacedScan>& scans, std::size_t from, std::size_t to,
                     double covered_s, double travel_m) const;
  /// Follows the vehicle from the scan `from`, leaves out the scans of `gap_s`, and goes on for
  /// three seconds.
  GapTrial followOverGap(const std::vector<PlacedScan>& scans, std::size_t from,
                         double gap_s) const;

 private:
  void compare(const PlacedScan& scan, RelocalizationTrial& trial) const;
  Submap mapToLocalizeIn(bool picture) const;

  MapperConfig config_;
  const std::vector<PlacedScan>& scans_;
  std::size_t first_, last_;
  Submap map_;
  GlobalMap global_;
};

}  // namespace kestrel
