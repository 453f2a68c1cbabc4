// SPDX-License-Identifier: BSD-3-Clause
// The exhaustive search finds the same pose as brute force in the map of a real building.

#include <gtest/gtest.h>

#include <random>

#include "kestrel_slam/experiments/mapped_log.h"
#include "kestrel_slam/matching/correlative.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kResolution_m = 0.03;

class SearchRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = dataFolder();
    SKIP_WITHOUT_DATA(folder);
    if (log().scans.empty()) log() = mapLog(folder + "/freiburg/fr079.clf.bz2", kResolution_m);
  }

  /// The map is built once for all tests.
  static MappedLog& log() {
    static MappedLog instance{Submap(OccupancyGridConfig()), {}};
    return instance;
  }

  /// Searches `count` scans of the recording, starting at random positions in the window.
  static void compare(std::size_t count, const SearchWindow& window, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    const SurfelField& surface = log().map.surface();
    for (std::size_t i = 0; i < count; ++i) {
      const MappedScan& scan = log().scans[i * log().scans.size() / count];
      const double x = window.linear_m * share(random), y = window.linear_m * share(random);
      const double turn = window.angular_rad * share(random);
      const Pose2 center(scan.pose.x + x, scan.pose.y + y, scan.pose.yaw + turn);
      const CorrelativeConfig config;
      const SearchResult found = searchWindow(surface, scan.points, center, window, config);
      const SearchResult expected =
          searchWindowBruteForce(surface, scan.points, center, window, config);
      ASSERT_GT(expected.score, 0.0);
      ASSERT_EQ(found.pose, expected.pose) << "scan " << i;
      ASSERT_EQ(found.score, expected.score) << "scan " << i;
      ASSERT_EQ(found.penalized_score, expected.penalized_score) << "scan " << i;
      ASSERT_EQ(found.mean, expected.mean) << "scan " << i;
      // The images of the two searches have different borders, which may cut off the outermost
      // poses of the surface.
      ASSERT_LT((found.covariance - expected.covariance).norm(), 1e-3 * expected.covariance.norm())
          << "scan " << i;
    }
  }
};

TEST_F(SearchRecording, EqualsBruteForceOnAThousandScans) {
  compare(1000, {0.5, 20.0 * kPi / 180.0}, 1);
}

TEST_F(SearchRecording, EqualsBruteForceInLargeWindows) { compare(6, {4.0, 0.5 * kPi}, 2); }

}  // namespace
}  // namespace kestrel
