// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/perturbation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kestrel {
namespace {

RecordedScan scanOf(std::size_t beams) {
  RecordedScan scan;
  scan.scan.ranges.assign(beams, 2.5F);
  return scan;
}

std::vector<std::size_t> droppedBeams(const RecordedScan& scan) {
  std::vector<std::size_t> dropped;
  for (std::size_t i = 0; i < scan.scan.ranges.size(); ++i) {
    if (std::isnan(scan.scan.ranges[i])) dropped.push_back(i);
  }
  return dropped;
}

TEST(PerturbationTest, WithoutPerturbationNothingChanges) {
  RecordedScan scan = scanOf(10);
  for (std::size_t number = 1; number < 100; ++number) {
    EXPECT_TRUE(perturb(Perturbation(), number, scan));
  }
  EXPECT_EQ(scan.scan.ranges, std::vector<float>(10, 2.5F));
}

TEST(PerturbationTest, RemovesTheFirstScansAndEveryNth) {
  Perturbation perturbation;
  perturbation.skip_scans = 4;
  perturbation.drop_every = 7;
  RecordedScan scan;
  std::vector<std::size_t> kept;
  for (std::size_t number = 1; number <= 15; ++number) {
    if (perturb(perturbation, number, scan)) kept.push_back(number);
  }
  EXPECT_EQ(kept, (std::vector<std::size_t>{5, 6, 8, 9, 10, 11, 12, 13, 15}));
}

TEST(PerturbationTest, RemovesTheShareOfTheBeamsAndKeepsTheOthers) {
  Perturbation perturbation;
  perturbation.drop_beams_share = 0.1;
  RecordedScan scan = scanOf(100000);
  ASSERT_TRUE(perturb(perturbation, 1, scan));
  const std::size_t dropped = droppedBeams(scan).size();
  EXPECT_NEAR(static_cast<double>(dropped), 10000.0, 4.0 * std::sqrt(9000.0));  // 4 sigma
  for (const float range : scan.scan.ranges) EXPECT_TRUE(std::isnan(range) || range == 2.5F);
  perturbation.drop_beams_share = 1.0;
  RecordedScan all = scanOf(100);
  ASSERT_TRUE(perturb(perturbation, 1, all));
  EXPECT_EQ(droppedBeams(all).size(), 100U);
}

TEST(PerturbationTest, BeamsDependOnlyOnScanNumberAndSeed) {
  Perturbation perturbation;
  perturbation.drop_beams_share = 0.3;
  const auto droppedIn = [&](std::size_t number) {
    RecordedScan scan = scanOf(360);
    EXPECT_TRUE(perturb(perturbation, number, scan));
    return droppedBeams(scan);
  };
  const std::vector<std::size_t> first = droppedIn(5), other_scan = droppedIn(6);
  EXPECT_EQ(droppedIn(5), first);
  EXPECT_NE(other_scan, first);
  perturbation.beams_seed = 2;
  EXPECT_NE(droppedIn(5), first);
}

TEST(PerturbationTest, AllValuesOfADroppedPointBecomeNan) {
  Perturbation perturbation;
  perturbation.drop_beams_share = 0.5;
  RecordedScan scan;
  scan.cloud.emplace();
  scan.cloud->points.assign(1000, {1.0F, 2.0F, 3.0F, 0.0F});
  ASSERT_TRUE(perturb(perturbation, 1, scan));
  std::size_t dropped = 0;
  for (const PointCloud::Point& point : scan.cloud->points) {
    const bool gone = std::isnan(point.x);
    EXPECT_EQ(std::isnan(point.y), gone);
    EXPECT_EQ(std::isnan(point.z), gone);
    dropped += gone ? 1U : 0U;
  }
  EXPECT_NEAR(static_cast<double>(dropped), 500.0, 64.0);  // 4 sigma
}

}  // namespace
}  // namespace kestrel
