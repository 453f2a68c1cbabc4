// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

struct MapperResult;
class SubmapGraph;

/// A scan, which may be a keyframe.
struct TrackedScan {
  Pose2 local_T_base;                ///< as mapped
  std::optional<Pose2> odom_T_base;  ///< the odometry at the scan
  std::size_t keyframes = 0;         ///< number of keyframes up to this scan
  bool inserted = false;             ///< it is the last one of them
  bool carried = false;              ///< it was not matched
  bool doubtful = false;             ///< its match may be wrong
  bool reversed = false;             ///< see MapperResult::reversed
};

/// `keyframes`: number of them up to this scan.
TrackedScan trackedScan(const MapperResult& result, std::size_t keyframes);

/// The poses of all scans of a flight in map. A scan that was matched moves with the keyframe
/// before it. One that was carried is placed by the odometry between the keyframes before and after
/// it, with the delay and the systematic errors that the graph has found: when it was carried,
/// neither was known. The same holds for a doubtful match that the odometry refutes.
std::vector<Pose2> scanPoses(const std::vector<TrackedScan>& scans, const SubmapGraph& graph);

}  // namespace kestrel
