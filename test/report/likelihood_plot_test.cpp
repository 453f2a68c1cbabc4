// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/likelihood_plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "kestrel_slam/sensor/scan_projector.h"
#include "room_log.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

TEST(LikelihoodRecorder, BestPoseIsTheTruePose) {
  constexpr std::size_t kScan = 15;
  const MapperConfig config;
  Mapper mapper(config);
  LikelihoodRecorder recorder(config, kScan);
  ScanProjector projector{ProjectorConfig()};
  for (int i = 0; i <= static_cast<int>(kScan); ++i) {
    PlanarScan scan = projector.project(RoomFlight::scan(i), Eigen::Isometry3d::Identity()).scan;
    scan.time = RoomFlight::stamp(i);
    recorder.add(scan, mapper.process(scan));
  }
  const LikelihoodSurface& surface = recorder.surface();
  const auto best = std::max_element(surface.score.begin(), surface.score.end());
  ASSERT_NE(best, surface.score.end());
  const int cell =
      static_cast<int>(best - surface.score.begin()) % (surface.side() * surface.side());
  const Pose2 pose = surface.pose(cell % surface.side() - surface.linear_steps,
                                  cell / surface.side() - surface.linear_steps, 0);
  EXPECT_NEAR(pose.x, RoomFlight::x(static_cast<int>(kScan)),
              0.05);  // one step of the likelihood grid
  EXPECT_NEAR(pose.y, 0.0, 0.05);
  const TemporaryFolder folder;
  recorder.write(folder.file("surface.png"));
  EXPECT_GT(std::filesystem::file_size(folder.file("surface.png")), 1000U);
  EXPECT_GT(std::filesystem::file_size(folder.file("surface.svg")), 1000U);
}

TEST(LikelihoodRecorder, ErrorsDescribeTheProblem) {
  EXPECT_THROW(LikelihoodRecorder(MapperConfig(), 0), std::invalid_argument);
  const LikelihoodRecorder recorder(MapperConfig(), 5);
  EXPECT_CONTAINS(messageOf([&] { recorder.write("surface.png"); }), "the run has 0 scans");
}

}  // namespace
}  // namespace kestrel
