// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// What is tried, and what counts as a good match.
struct ExperimentConfig {
  std::size_t every = 10;    ///< only every so manieth scan is matched again,
  int initial_guesses = 5;   ///< from so many displaced initial guesses,
  double linear_m = 1.0;     ///< each up to so far in x and y
  double angular_rad = 0.5;  ///< and in yaw from the undisturbed pose
  double good_m = 0.1;       ///< a match that ends no farther from the undisturbed pose is good
  double good_rad = 0.035;
};

/// Does the evaluation function (paper 000 eq. 4-5) tell good from bad matches?
///
/// Watches a mapper, whose poses are taken to be right, and matches some of its scans again with
/// the same map, but from displaced initial guesses, so that some matches end in wrong optima.
/// Deterministic.
class EvaluationExperiment {
 public:
  /// One match from a displaced initial guess.
  struct Trial {
    double evaluation = 0.0;  ///< f: small is good
    bool good = false;        ///< it ended where the undisturbed match did
  };

  /// `mapper.matcher.method` is the method that is tried.
  EvaluationExperiment(const MapperConfig& mapper, const ExperimentConfig& config);

  /// What the watched mapper made of its next scan.
  void add(const PlanarScan& scan, const MapperResult& result);

  const std::vector<Trial>& trials() const { return trials_; }

 private:
  void tryInitialGuesses(const PlanarScan& scan, const Pose2& undisturbed);

  MapperConfig mapper_;
  ExperimentConfig config_;
  std::unique_ptr<Matcher> matcher_;
  Submap map_;
  Random random_;
  std::size_t scans_ = 0;
  std::vector<Trial> trials_;
};

/// The trials of one method.
struct MethodTrials {
  std::string method;
  std::vector<EvaluationExperiment::Trial> trials;
};

/// How a threshold divides the trials.
struct Separation {
  std::size_t good = 0, bad = 0;
  double good_refused = 0.0;  ///< share of the good ones above the threshold
  double bad_accepted = 0.0;  ///< share of the bad ones below it
};

Separation separate(const std::vector<EvaluationExperiment::Trial>& trials, double threshold);

/// The threshold, in steps of 0.05, at which the sum of both shares is smallest.
double bestThreshold(const std::vector<EvaluationExperiment::Trial>& trials);

/// A Markdown table of all methods.
std::string evaluationTable(const std::vector<MethodTrials>& methods, double threshold);

/// Writes a PNG: for each method the histograms of f of good and bad matches, and the threshold.
void plotEvaluationFunction(const std::string& path, const std::vector<MethodTrials>& methods,
                            double threshold);

}  // namespace kestrel
