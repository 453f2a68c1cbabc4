// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/phd_scenario.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kestrel {
namespace {

// Independent implementation: 20.7 m, localization 10.5 m, cardinality 10.25 m, single runs 17.4 to
// 24.3 m. Fewer runs than measure_tracking, so that the test is short.
constexpr std::size_t kRuns = 30;

TEST(PhdScenario, OspaOfTheStandardScenarioIsTheKnownOne) {
  const PhdScenarioSummary s = summarizeScenario(standardScenario(), kRuns);
  EXPECT_NEAR(s.ospa, 20.7, 0.6);
  EXPECT_NEAR(s.localization, 10.5, 0.4);
  EXPECT_NEAR(s.cardinality, 10.25, 0.6);
  EXPECT_NEAR(s.count_bias, 0.23, 0.15);
  EXPECT_GT(s.best, 17.0);
  EXPECT_LT(s.worst, 26.5);
}

TEST(PhdScenario, LabeledTargetsAreBetter) {
  PhdScenario scenario = standardScenario();
  scenario.labeled = true;
  const PhdScenarioSummary s = summarizeScenario(scenario, kRuns);
  EXPECT_LT(s.ospa, 19.5);
  EXPECT_NEAR(s.count_bias, 0.0, 0.25);
}

TEST(PhdScenario, SpawnedTargetIsFound) {
  const PhdScenarioSummary s = summarizeScenario(spawningScenario(), kRuns);
  const auto found = std::count_if(s.single.begin(), s.single.end(), [](const auto& run) {
    return run.found_after[2] >= 0 && run.found_after[2] <= 3;
  });
  EXPECT_GE(found, 27);
}

TEST(PhdScenario, SameSeedGivesTheSameRun) {
  const PhdScenario scenario = standardScenario();
  EXPECT_EQ(runScenario(scenario, 5).ospa, runScenario(scenario, 5).ospa);
  EXPECT_NE(runScenario(scenario, 5).ospa, runScenario(scenario, 6).ospa);
}

}  // namespace
}  // namespace kestrel
