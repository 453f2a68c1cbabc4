// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/evaluation/track_file.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// What the page of the tracks shows.
struct TracksPage {
  std::string title;  ///< name of the recording
  MapSnapshot map;
  Trajectory map_path;   ///< poses of the vehicle in the map
  Trajectory odom_path;  ///< the same in the frame of the tracks, one for each of `frames`
  std::vector<TrackFrame> frames;
};

/// A self-contained HTML page: the map with the objects that moved, a slider for the time, and the
/// speed of each object over time. The tracks are moved into the map by the two paths.
std::string tracksHtml(const TracksPage& page);

}  // namespace kestrel
