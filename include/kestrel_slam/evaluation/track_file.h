// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {

/// The tracks of one scan.
struct TrackFrame {
  double stamp = 0.0;  ///< of the scan, as recorded, s
  std::vector<Track> tracks;
  bool saturated = false;
};

/// The columns of tracks.csv that an evaluation needs.
struct TrackRow {
  double stamp = 0.0;
  long id = 0;
  bool shown = false;  ///< see Track::isShown()
  Eigen::Vector2d position = Eigen::Vector2d::Zero(), velocity = Eigen::Vector2d::Zero();
  bool tentative = false, moved = false;  ///< see Track
};

/// One line for each track and scan: the content of tracks.csv.
std::string tracksCsv(const std::vector<TrackFrame>& frames);
/// One object for each track that was shown, with its path: the content of tracks.json.
std::string tracksJson(const std::vector<TrackFrame>& frames);
/// Reads tracks.csv. Throws std::runtime_error with the file, the line and the error.
std::vector<TrackRow> readTracks(const std::string& path);

}  // namespace kestrel
