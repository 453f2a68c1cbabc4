// SPDX-License-Identifier: BSD-3-Clause
// Tests on the real recordings, laser only and with odometry, against the limits in the
// documentation.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {
namespace {

std::string dataFile(const std::string& name) {
  const char* folder = std::getenv("KESTREL_DATA");
  return (folder != nullptr ? std::string(folder)
                            : std::string(KESTREL_SOURCE_DIR) + "/../shared/data") +
         "/freiburg/" + name;
}

struct LogRun {
  Trajectory trajectory;
  MapSnapshot map;
  std::size_t scans = 0;
  std::size_t lost = 0;
  std::size_t memory_bytes = 0;
};

LogRun mapLog(const std::string& name, bool use_odometry, const SlamConfig& config = SlamConfig(),
              std::size_t max_scans = std::numeric_limits<std::size_t>::max()) {
  const std::unique_ptr<Recording> recording = openRecording(dataFile(name + ".clf.bz2"));
  RunOptions options;
  options.use_odometry = use_odometry;
  options.max_scans = max_scans;
  const OfflineRun run = runOffline(*recording, config, options);
  return {run.trajectory, run.map, run.scans.size(), summarize(run.scans).lost,
          run.map_memory_bytes};
}

double meanError(const LogRun& run, const std::string& name) {
  return evaluateRelations(run.trajectory, readRelations(dataFile(name + ".relations")))
      .all.translation_m.mean;
}

class Freiburg : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(dataFile("fr079.clf.bz2"))) {
      GTEST_SKIP() << dataFile("fr079.clf.bz2") << " is absent: set KESTREL_DATA";
    }
  }
};

TEST_F(Freiburg, Building79LaserOnly) {
  const LogRun run = mapLog("fr079", false);
  EXPECT_EQ(run.scans, 4934U);
  EXPECT_EQ(run.lost, 0U);
  EXPECT_LT(meanError(run, "fr079"), 0.033);
  EXPECT_LT(run.memory_bytes, 20000000U);
}

TEST_F(Freiburg, Building79WithUnsignedOdometry) {
  const LogRun run = mapLog("fr079", true);
  EXPECT_EQ(run.lost, 0U);
  EXPECT_LT(meanError(run, "fr079"), 0.033);
}

TEST_F(Freiburg, SameRecordingGivesTheSameMap) {
  const LogRun first = mapLog("fr079", true), second = mapLog("fr079", true);
  ASSERT_EQ(first.trajectory.size(), second.trajectory.size());
  for (std::size_t i = 0; i < first.trajectory.size(); ++i) {
    ASSERT_EQ(first.trajectory[i].pose, second.trajectory[i].pose) << "scan " << i;
  }
  EXPECT_EQ(first.map.cells, second.map.cells);
}

TEST_F(Freiburg, Building79AtOtherInsertDistance) {
  SlamConfig config;
  config.mapper.insert_distance_m = 0.24;
  const LogRun run = mapLog("fr079", false, config);
  EXPECT_EQ(run.lost, 0U);
  EXPECT_LT(meanError(run, "fr079"), 0.035);
}

TEST_F(Freiburg, IntelLaserOnly) {
  const LogRun run = mapLog("intel", false);
  EXPECT_EQ(run.scans, 13631U);
  EXPECT_EQ(run.lost, 0U);
  EXPECT_LT(meanError(run, "intel"), 0.020);
}

TEST_F(Freiburg, Building79ProgressivelyLaserOnly) {
  SlamConfig config;
  config.mapper.matcher.method = "progressive";
  const LogRun run = mapLog("fr079", false, config, 1000);
  EXPECT_EQ(run.scans, 1000U);
  EXPECT_EQ(run.lost, 0U);
  EXPECT_LT(meanError(run, "fr079"), 0.026);
}

TEST_F(Freiburg, MitCsailLaserOnlyIsNeverLost) {
  const LogRun run = mapLog("mit-csail", false);
  EXPECT_EQ(run.scans, 1988U);
  EXPECT_EQ(run.lost, 0U);
  // Laser only and with odometry the trajectories end at the same place.
  const LogRun with_odometry = mapLog("mit-csail", true);
  EXPECT_EQ(with_odometry.lost, 0U);
  const Pose2 difference =
      run.trajectory.back().pose.inverse() * with_odometry.trajectory.back().pose;
  EXPECT_LT(difference.distance(), 0.5);
}

/// Every variant of icp on the first 1000 scans of fr079.
TEST_F(Freiburg, IcpLaserOnly) {
  SlamConfig config;
  config.mapper.matcher.method = "icp";
  for (const char* metric : {"point_to_point", "point_to_line"}) {
    for (const char* reference : {"map", "last_scans"}) {
      for (const bool stitching : {false, true}) {
        config.mapper.matcher.icp.metric = metric;
        config.mapper.matcher.icp.reference = reference;
        config.mapper.matcher.icp.stitching = stitching;
        const LogRun run = mapLog("fr079", false, config, 1000);
        EXPECT_EQ(run.scans, 1000U);
        EXPECT_EQ(run.lost, 0U) << metric << " " << reference << " " << stitching;
        EXPECT_LT(meanError(run, "fr079"), 0.04) << metric << " " << reference << " " << stitching;
      }
    }
  }
}

}  // namespace
}  // namespace kestrel
