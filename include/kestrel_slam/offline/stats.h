// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Input and configuration of a run: the part of the output that is known before the run.
struct RunInfo {
  std::string recording;    ///< the file's name, without its folder
  std::string description;  ///< one line about the file
  std::string hash;         ///< of the content of the files
  /// Name and value of the options that change the result, beside the parameters.
  std::vector<std::pair<std::string, std::string>> options;
  SlamConfig config;
  bool odometry = false;
  bool timing = true;  ///< false: omit measured times, so that two runs give identical files
};

/// Mean, median, 99th percentile and maximum.
struct Distribution {
  double mean = 0.0;
  double median = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// All zero if there are no values.
Distribution distributionOf(std::vector<double> values);

/// Processing time of one part of the work for each scan, ms.
Distribution stageTimes(const OfflineRun& run, PipelineStage stage);
/// Processing time of each scan, ms, for a part of the run. The part is given by two shares of the
/// number of scans, 0 to 1.
Distribution scanTimes(const OfflineRun& run, double from = 0.0, double to = 1.0);

/// Number of scans in each match state, and their scores.
struct MatchSummary {
  std::size_t ok = 0;
  std::size_t degraded = 0;
  std::size_t lost = 0;
  std::size_t inserted = 0;
  std::size_t searched = 0;
  double mean_score = 0.0;
  double min_score = 0.0;
};

MatchSummary summarize(const std::vector<ScanRecord>& scans);

/// Area of the known cells, m².
double knownArea(const MapSnapshot& map);

/// Rounds `value` to a number of decimals, so that files stay readable.
double rounded(double value, int decimals);

/// The content of stats.json. All measured times and memory sizes are in the object "timing", which
/// is omitted if timing is off. All other values are the same in every run.
nlohmann::ordered_json statsOf(const OfflineRun& run, const RunInfo& info);

}  // namespace kestrel
