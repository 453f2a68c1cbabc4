// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/scan_poses.h"

#include <gtest/gtest.h>

#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

/// A straight drive with a scan per meter, whose odometry is exact but a scan late. Every third
/// scan is no keyframe.
struct LateDrive {
  static constexpr std::size_t kCount = 60;
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  std::vector<Pose2> truth;
  std::vector<TrackedScan> scans;

  /// `local(scan, truth)`: the pose by the mapper.
  template <typename Local>
  LateDrive(bool carried, Local local) {
    for (std::size_t i = 0; i < kCount; ++i) {
      const double way = static_cast<double>(i) + 0.2 * static_cast<double>(i * i % 7);
      truth.emplace_back(way, 0.0, 0.0);
      MapperResult result;
      result.state = i % 3 == 1 ? MatchState::kDegraded : MatchState::kOk;
      result.inserted = i % 3 != 1;
      result.carried = carried && !result.inserted;
      result.pose = result.inserted ? truth.back() : local(i, truth);
      result.odom_T_base = truth[i == 0 ? 0 : i - 1];
      PlanarScan scan;
      scan.stamp = scan.time = static_cast<double>(i);
      graph.add(scan, result);
      scans.push_back(trackedScan(result, graph.keyframes().size()));
    }
    graph.finish();
  }

  /// The largest error of a scan that is no keyframe, m. The last scan has no odometry.
  double worst() const {
    const std::vector<Pose2> poses = scanPoses(scans, graph);
    double result = 0.0;
    for (std::size_t i = 0; i + 1 < kCount; ++i)
      if (!scans[i].inserted) result = std::max(result, truth[i].between(poses[i]).distance());
    return result;
  }
};

TEST(ScanPoses, ACarriedScanIsPlacedByTheOdometryWithoutItsDelay) {
  const LateDrive drive(true, [](std::size_t i, const std::vector<Pose2>& t) { return t[i - 1]; });
  EXPECT_EQ(drive.graph.odometry().delayScans(), 1);
  EXPECT_LT(drive.worst(), 0.05);
}

TEST(ScanPoses, ADoubtfulMatchThatTheOdometryRefutesIsReplaced) {
  const LateDrive drive(false, [](std::size_t i, const std::vector<Pose2>& t) { return t[i - 1]; });
  EXPECT_LT(drive.worst(), 0.05);
}

TEST(ScanPoses, AMatchThatTheOdometryConfirmsStays) {
  const LateDrive drive(false, [](std::size_t i, const std::vector<Pose2>& t) {
    return t[i] * Pose2(0.0, 0.02, 0.0);
  });
  EXPECT_NEAR(drive.worst(), 0.02, 1e-3);
}

}  // namespace
}  // namespace kestrel
