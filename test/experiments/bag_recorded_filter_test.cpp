// SPDX-License-Identifier: BSD-3-Clause
// The filter on real cars with motion capture, and a cheap laser whose error is known.

#include <gtest/gtest.h>

#include <stdexcept>

#include "kestrel_slam/experiments/recorded_filter.h"
#include "kestrel_slam/recording/bag/bag_reference.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr char kCorrection[] =
    "3.86:0.14, 4.27:0.23, 4.66:0.345, 5.04:0.465, 5.55:0.45, 6.1:0.4, 6.62:0.38";

RecordedFilterRun runBag(const std::string& path, bool coupled) {
  SlamConfig config;
  config.projector.range_correction = kCorrection;
  CouplingOptions coupling;
  coupling.attitude = coupling.height = coupling.prediction = coupled;
  const auto recording = openRecording(path);
  return runFiltered(*recording, config, PoseFilterConfig(), coupling,
                     Eigen::Isometry3d(Eigen::Translation3d(-0.165, 0.0, 0.0)));
}

TEST(RecordedFilter, BetterThanTheMapperAlone) {
  const std::string folder = dataFolder();
  SKIP_WITHOUT_DATA(folder);
  const std::string path = folder + "/moving/overtakes.bag";
  const Trajectory reference = readBagReference(path, "/ego_pose");
  const MovingErrors alone = compareWithReference(runBag(path, false).mapper, reference);
  const RecordedFilterRun run = runBag(path, true);
  const MovingErrors filtered = compareWithReference(run.filter, reference);
  EXPECT_GT(filtered.count, alone.count);
  EXPECT_LT(filtered.position_rmse_m, 0.07);
  EXPECT_LT(filtered.position_rmse_m, alone.position_rmse_m);
  EXPECT_LT(filtered.velocity_rmse, 0.2);
  EXPECT_LT(filtered.velocity_rmse, 0.6 * alone.velocity_rmse);
  EXPECT_TRUE(run.status.resets.empty());
}

TEST(RecordedFilter, NeedsAnImu) {
  const std::string folder = dataFolder();
  SKIP_WITHOUT_DATA(folder);
  const auto recording = openRecording(folder + "/mav/urg04lx_mines_exp2.dat");
  EXPECT_THROW(runFiltered(*recording, SlamConfig(), PoseFilterConfig(), CouplingOptions()),
               std::runtime_error);
}

}  // namespace
}  // namespace kestrel
