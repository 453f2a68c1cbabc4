// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/evaluation_experiment.h"

#include <gtest/gtest.h>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

using Trial = EvaluationExperiment::Trial;

TEST(EvaluationExperimentTest, SeparateCountsBothKindsOfErrors) {
  const std::vector<Trial> trials = {{1.0, true},  {1.2, true},  {3.0, true},
                                     {1.1, true},  {2.0, false}, {1.5, false},
                                     {4.0, false}, {2.5, false}, {9.0, false}};
  const Separation separation = separate(trials, 2.0);  // f = 2 is rejected
  EXPECT_EQ(separation.good, 4U);
  EXPECT_EQ(separation.bad, 5U);
  EXPECT_DOUBLE_EQ(separation.good_rejected, 0.25);
  EXPECT_DOUBLE_EQ(separation.bad_accepted, 0.2);
  // The smallest threshold above the good matches at 1.2 and below the bad match at 1.5.
  EXPECT_NEAR(bestThreshold(trials), 1.25, 1e-9);
}

TEST(EvaluationExperimentTest, WithoutTrialsBothFractionsAreZero) {
  const Separation separation = separate({}, 2.0);
  EXPECT_EQ(separation.good + separation.bad, 0U);
  EXPECT_EQ(separation.good_rejected, 0.0);
  EXPECT_EQ(separation.bad_accepted, 0.0);
}

/// Runs the experiment with `method` on the first seconds of a simulated flight.
std::vector<Trial> tryOut(const std::string& method, const ExperimentConfig& experiment_config) {
  Place laboratory = place("laboratory");
  laboratory.quadrotor.level = true;
  SimulatedRecording flight(laboratory, quadrotorWith("utm30lx"), 1);
  const SlamConfig config;
  EvaluationExperiment experiment(config.mapper, method, experiment_config);
  RunOptions options;
  options.max_scans = 120;
  options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    experiment.add(scan, result);
  };
  runOffline(flight, config, options);
  return experiment.trials();
}

TEST(EvaluationExperimentTest, UndisplacedInitialGuessesAreGoodAndAccepted) {
  ExperimentConfig config;
  config.linear_m = 0.0;
  config.angular_rad = 0.0;
  const std::vector<Trial> trials = tryOut("hybrid", config);
  EXPECT_EQ(trials.size(), 60U);  // every tenth of 120 scans, five times
  const Separation separation = separate(trials, EvaluationConfig().threshold);
  EXPECT_EQ(separation.bad, 0U);
  EXPECT_EQ(separation.good_rejected, 0.0);
}

TEST(EvaluationExperimentTest, DefaultThresholdRejectsMostBadMatches) {
  const std::vector<Trial> trials = tryOut("gauss_newton", ExperimentConfig());
  const Separation separation = separate(trials, EvaluationConfig().threshold);
  ASSERT_GT(separation.bad, 10U);
  ASSERT_GT(separation.good, 3U);
  EXPECT_LT(separation.bad_accepted, 0.3);
  EXPECT_LT(separation.good_rejected, 0.5);
}

TEST(EvaluationExperimentTest, WritesTableAndPlotOfEachMethod) {
  const std::vector<MethodTrials> methods = {{"hybrid", {{1.0, true}, {3.0, false}}},
                                             {"icp", {{1.0, true}, {1.1, false}}}};
  const std::string table = evaluationTable(methods, 2.0);
  EXPECT_CONTAINS(table, "| hybrid | 1 | 1 | 2.00 | 0.0 % | 0.0 % |\n");
  EXPECT_CONTAINS(table, "| icp | 1 | 1 | 2.00 | 0.0 % | 100.0 % |\n");
  EXPECT_CONTAINS(table, "| icp | 1 | 1 | 1.05 (best) | 0.0 % | 0.0 % |\n");
  TemporaryFolder folder;
  plotEvaluationFunction(folder.file("evaluation.png"), methods, 2.0);
  EXPECT_GT(std::filesystem::file_size(folder.file("evaluation.png")), 1000U);
}

}  // namespace
}  // namespace kestrel
