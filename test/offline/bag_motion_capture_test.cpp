// SPDX-License-Identifier: BSD-3-Clause
// Three recordings of real cars with motion capture, mapped with the laser only. The laser is cheap
// and has a known range error. Its correction was estimated only from the recording `overtakes`:
// the captured poses give the true positions of two walls.

#include <gtest/gtest.h>

#include <optional>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/bag/bag_reference.h"
#include "kestrel_slam/recording/recording.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr char kCorrection[] =
    "3.86:0.14, 4.27:0.23, 4.66:0.345, 5.04:0.465, 5.55:0.45, 6.1:0.4, 6.62:0.38";
constexpr double kBehind = -0.165;  // m; position of the laser, missing in two of the bags

struct Drive {
  const char* bag;
  const char* topic;
  bool has_mounting;
  double limit_m;  ///< limit of the mean position error, about 20 % above the measured one
};

class MotionCapture : public ::testing::TestWithParam<Drive> {};

TEST_P(MotionCapture, LaserOnly) {
  const std::string folder = dataFolder();
  SKIP_WITHOUT_DATA(folder);
  const std::string path = folder + "/moving/" + GetParam().bag;
  SlamConfig config;
  config.projector.range_correction = kCorrection;
  RunOptions options;
  options.use_imu = false;
  if (!GetParam().has_mounting) {
    options.base_T_laser = Eigen::Isometry3d(Eigen::Translation3d(kBehind, 0.0, 0.0));
  }
  const auto recording = openRecording(path);
  const OfflineRun run = runOffline(*recording, config, options);
  const ReferenceEvaluation error =
      evaluateReference(run.trajectory, readBagReference(path, GetParam().topic));
  EXPECT_LT(error.ate_statistics.translation_m.mean, GetParam().limit_m);
}

INSTANTIATE_TEST_SUITE_P(Bags, MotionCapture,
                         ::testing::Values(Drive{"overtakes.bag", "/ego_pose", false, 0.032},
                                           Drive{"parallel.bag", "/ego_pose", false, 0.035},
                                           Drive{"two_robots.bag", "/mocap_pose", true, 0.031}));

}  // namespace
}  // namespace kestrel
