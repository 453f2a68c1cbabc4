// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/offline/replayed_map.h"

namespace kestrel {

/// Settings of the experiment, and the limits of a good match.
struct ExperimentConfig {
  std::size_t every = 10;    ///< every N-th scan is matched again
  int initial_guesses = 5;   ///< number of displaced initial guesses per scan
  double linear_m = 1.0;     ///< largest displacement in x and in y
  double angular_rad = 0.5;  ///< largest displacement in yaw
  double good_m = 0.1;       ///< a match is good up to this distance from the undisturbed pose
  double good_rad = 0.035;   ///< and up to this difference in yaw
};

/// Measures how well the evaluation function [MAV SLAM 2013, eq. 4-5] separates good and bad
/// matches.
///
/// Uses the scans and poses of a mapper; the poses are assumed to be correct. Matches some scans
/// again in the same map, but from displaced initial guesses, so that some matches end in wrong
/// optima. Deterministic.
class EvaluationExperiment {
 public:
  /// One match from a displaced initial guess.
  struct Trial {
    double evaluation = 0.0;  ///< value of the evaluation function; small values are good
    bool good = false;        ///< the match ended close to the undisturbed pose
  };

  /// `mapper`: of the mapper whose results are added. `method`: the matcher under test.
  EvaluationExperiment(const MapperConfig& mapper, const std::string& method,
                       const ExperimentConfig& config);

  /// Adds the next scan of the mapper and its result.
  void add(const PlanarScan& scan, const MapperResult& result);

  const std::vector<Trial>& trials() const { return trials_; }
  const Submap& map() const { return map_.map(); }

 private:
  void tryInitialGuesses(const PlanarScan& scan, const Pose2& undisturbed);

  MapperConfig mapper_;
  ExperimentConfig config_;
  std::unique_ptr<Matcher> matcher_;
  ReplayedMap map_;
  Random random_;
  std::size_t scans_ = 0;
  std::vector<Trial> trials_;
};

/// The trials of one method.
struct MethodTrials {
  std::string method;
  std::vector<EvaluationExperiment::Trial> trials;
};

/// How well a threshold separates good and bad matches.
struct Separation {
  std::size_t good = 0, bad = 0;
  double good_rejected = 0.0;  ///< fraction of good matches at or above the threshold
  double bad_accepted = 0.0;   ///< fraction of bad matches below the threshold
};

Separation separate(const std::vector<EvaluationExperiment::Trial>& trials, double threshold);

/// The threshold with the smallest sum of both fractions, in steps of 0.05.
double bestThreshold(const std::vector<EvaluationExperiment::Trial>& trials);

/// A Markdown table of all methods.
std::string evaluationTable(const std::vector<MethodTrials>& methods, double threshold);

/// Writes a PNG with the histograms of the evaluation function for good and bad matches of each
/// method, and the threshold.
void plotEvaluationFunction(const std::string& path, const std::vector<MethodTrials>& methods,
                            double threshold);

}  // namespace kestrel
