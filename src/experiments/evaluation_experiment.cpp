// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/evaluation_experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "kestrel_slam/mapping/evaluation_function.h"
#include "kestrel_slam/report/plot.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kSeed = 1;
/// Range and step of the thresholds, and bin size of the histogram. f (the evaluation function) is
/// always at least 1.
constexpr double kLeast = 1.0, kMost = 6.0, kStep = 0.05, kBin = 0.1;
constexpr double kPercent = 100.0;
constexpr double kSmallestShown = 0.1;  // %

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", kPercent * share);
  return text;
}

/// The outline of the histogram in percent of the good or of the bad matches. The last bin also
/// contains all larger values.
std::vector<Eigen::Vector2d> histogram(const std::vector<EvaluationExperiment::Trial>& trials,
                                       bool good) {
  std::vector<double> bins(static_cast<std::size_t>(std::lround((kMost - kLeast) / kBin)), 0.0);
  double count = 0.0;
  for (const EvaluationExperiment::Trial& trial : trials) {
    if (trial.good != good) continue;
    const double last = static_cast<double>(bins.size() - 1);
    const double bin = std::clamp((trial.evaluation - kLeast) / kBin, 0.0, last);
    bins[static_cast<std::size_t>(bin)] += 1.0;
    count += 1.0;
  }
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t i = 0; i < bins.size() && count > 0.0; ++i) {
    const double left = kLeast + kBin * static_cast<double>(i), share = kPercent * bins[i] / count;
    outline.emplace_back(left, share);
    outline.emplace_back(left + kBin, share);
  }
  // On the logarithmic axis, empty bins are at the lower end.
  for (Eigen::Vector2d& point : outline) point.y() = std::max(point.y(), kSmallestShown);
  return outline;
}

PlotPanel histogramPanel(const MethodTrials& method, double threshold) {
  PlotPanel panel;
  panel.title = method.method + ": evaluation function f of matches from displaced initial guesses";
  panel.x_label = "f (last bin: all larger values)";
  panel.y_label = "fraction of good or bad, %";
  panel.log_y = true;
  panel.series = {{"good", histogram(method.trials, true)},
                  {"bad", histogram(method.trials, false)},
                  {"threshold", {{threshold, kSmallestShown}, {threshold, kPercent}}}};
  return panel;
}

PlotPanel sharesPanel(const MethodTrials& method, double threshold) {
  PlotPanel panel;
  panel.title = method.method + ": effect of the threshold";
  panel.x_label = "threshold of f";
  panel.y_label = "fraction of good or bad, %";
  panel.from_zero = true;
  PlotSeries rejected{"good, rejected", {}}, accepted{"bad, accepted", {}};
  for (double at = kLeast; at <= kMost; at += kStep) {
    const Separation separation = separate(method.trials, at);
    rejected.points.emplace_back(at, kPercent * separation.good_rejected);
    accepted.points.emplace_back(at, kPercent * separation.bad_accepted);
  }
  panel.series = {rejected, accepted, {"threshold", {{threshold, 0.0}, {threshold, kPercent}}}};
  return panel;
}

MatcherConfig withMethod(MatcherConfig config, const std::string& method) {
  config.method = method;
  return config;
}

}  // namespace

EvaluationExperiment::EvaluationExperiment(const MapperConfig& mapper, const std::string& method,
                                           const ExperimentConfig& config)
    : mapper_(mapper),
      config_(config),
      matcher_(makeMatcher(withMethod(mapper.matcher, method))),
      map_(mapper, submapOptions(withMethod(mapper.matcher, method))),
      random_(kSeed) {}

void EvaluationExperiment::add(const PlanarScan& scan, const MapperResult& result) {
  if (++scans_ % config_.every == 0 && result.state == MatchState::kOk && map().scans() > 0) {
    tryInitialGuesses(scan, result.pose);
  }
  map_.add(scan, result);
}

void EvaluationExperiment::tryInitialGuesses(const PlanarScan& scan, const Pose2& undisturbed) {
  const Points points = hitsOf(scan);
  for (int i = 0; i < config_.initial_guesses; ++i) {
    const double x = random_.uniform(-config_.linear_m, config_.linear_m);
    const double y = random_.uniform(-config_.linear_m, config_.linear_m);
    const double turn = random_.uniform(-config_.angular_rad, config_.angular_rad);
    const Pose2 initial_guess = undisturbed * Pose2(x, y, turn);
    MatchRequest request{points, initial_guess, {initial_guess}};
    const MatchResult match = matcher_->match(map(), request);
    const Pose2 error = undisturbed.inverse() * match.pose;
    trials_.push_back(
        {evaluationFunction(match, mapper_.evaluation),
         error.distance() <= config_.good_m && std::abs(error.yaw) <= config_.good_rad});
  }
}

Separation separate(const std::vector<EvaluationExperiment::Trial>& trials, double threshold) {
  Separation result;
  double rejected = 0.0, accepted = 0.0;
  for (const EvaluationExperiment::Trial& trial : trials) {
    const bool is_accepted = trial.evaluation < threshold;
    (trial.good ? result.good : result.bad) += 1;
    if (trial.good && !is_accepted) rejected += 1.0;
    if (!trial.good && is_accepted) accepted += 1.0;
  }
  if (result.good > 0) result.good_rejected = rejected / static_cast<double>(result.good);
  if (result.bad > 0) result.bad_accepted = accepted / static_cast<double>(result.bad);
  return result;
}

double bestThreshold(const std::vector<EvaluationExperiment::Trial>& trials) {
  double best = kLeast, least = 2.0;
  for (int i = 0; kLeast + i * kStep <= kMost; ++i) {
    const double threshold = kLeast + i * kStep;
    const Separation separation = separate(trials, threshold);
    const double sum = separation.good_rejected + separation.bad_accepted;
    if (sum >= least) continue;
    least = sum;
    best = threshold;
  }
  return best;
}

std::string evaluationTable(const std::vector<MethodTrials>& methods, double threshold) {
  std::string table =
      "| matcher | good matches | bad matches | threshold | good rejected | bad accepted |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: |\n";
  for (const MethodTrials& method : methods) {
    for (const double at : {threshold, bestThreshold(method.trials)}) {
      const Separation separation = separate(method.trials, at);
      char text[32];
      std::snprintf(text, sizeof text, at == threshold ? "%.2f" : "%.2f (best)", at);
      table += "| " + method.method + " | " + std::to_string(separation.good) + " | " +
               std::to_string(separation.bad) + " | " + text + " | " +
               percent(separation.good_rejected) + " | " + percent(separation.bad_accepted) +
               " |\n";
    }
  }
  return table;
}

void plotEvaluationFunction(const std::string& path, const std::vector<MethodTrials>& methods,
                            double threshold) {
  std::vector<PlotPanel> panels;
  for (const MethodTrials& method : methods) {
    panels.push_back(histogramPanel(method, threshold));
    panels.push_back(sharesPanel(method, threshold));
  }
  writePlot(path, panels);
}

}  // namespace kestrel
