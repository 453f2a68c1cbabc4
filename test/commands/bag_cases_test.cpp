// SPDX-License-Identifier: BSD-3-Clause
// map_recording on small recordings that reproduce what drivers and users really send.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "kestrel_slam/recording/trajectory.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The folder of the cases; empty if it is absent.
std::string casesFolder() {
  const char* set = std::getenv("KESTREL_CASES");
  const std::string folder = set != nullptr ? set : KESTREL_SOURCE_DIR "/../shared/cases";
  return std::filesystem::is_directory(folder) ? folder : std::string();
}

/// The drive of most cases; `t` in s since the first scan.
Pose2 trueDrive(double t) {
  constexpr double kRate = 0.5 / 1.5;
  return {1.5 * std::sin(kRate * t), 0.6 * std::sin(0.7 * kRate * t), 0.9 * std::sin(0.25 * t)};
}

class BagCases : public ::testing::Test {
 protected:
  void SetUp() override {
    cases_ = casesFolder();
    if (cases_.empty()) GTEST_SKIP() << "no cases: neither KESTREL_CASES nor ../shared/cases";
  }

  Outcome map(const std::string& name, const std::string& options = "") {
    return runCommand(KESTREL_TOOL_DIR "/map_recording --quiet " + cases_ + "/" + name +
                      "/in.bag --output " + folder_.file("out") + " " + options);
  }

  /// Largest distance from the truth, m.
  double error(double start) const {
    const Trajectory trajectory = readTum(folder_.file("out/trajectory.tum"));
    const Pose2 first = trueDrive(trajectory.front().stamp - start);
    double worst = 0.0;
    for (const StampedPose& pose : trajectory) {
      const Pose2 truth = first.inverse() * trueDrive(pose.stamp - start);
      const Pose2 estimate = trajectory.front().pose.inverse() * pose.pose;
      worst = std::max(worst, (truth.inverse() * estimate).distance());
    }
    return worst;
  }

  void expectRight(const std::string& name, const std::string& options = "", double start = 1.7e9) {
    const Outcome outcome = map(name, options);
    ASSERT_EQ(outcome.code, 0) << name << ": " << outcome.output;
    EXPECT_LT(error(start), 0.15) << name << ": " << outcome.output;
  }

  std::string cases_;
  TemporaryFolder folder_;
};

TEST_F(BagCases, AreMappedRight) {
  for (const char* name :
       {"01_nav310_negative_increment", "02_rplidar_beams_and_start_vary",
        "04_namespaced_frames_uav0", "14_d435i_gyro_and_accel_apart",
        "15b_livox_timestamp_of_device", "16_bag_has_map_to_odom", "17_picoscan_three_echo_frames",
        "18_scan_in_segments", "18b_segments_and_full_turns", "20_multi_echo_only",
        "20b_point_cloud_v1", "33_utm_odometry"}) {
    expectRight(name);
  }
  expectRight("43_lidar_clock_unix_tf_boot", "", 91.0);
  expectRight("35_mavros_tf_without_laser", "--laser-pose 0.1,0,0");
  expectRight("13_imu_all_covariances_minus_one", "--imu none");
  expectRight("31_imu_frame_unknown", "--imu none");
}

TEST_F(BagCases, TheReasonIsTheMostFrequentOne) {
  const Outcome marked = map("13_imu_all_covariances_minus_one");
  EXPECT_EQ(marked.code, 1);
  EXPECT_CONTAINS(marked.output, "80 of 80 dropped (imu-invalid)");
  EXPECT_CONTAINS(marked.output, "covariance[0] is -1, although there are values");
  EXPECT_CONTAINS(marked.output, "--imu none maps without the IMU");
  const Outcome upside_down = map("31_imu_frame_unknown");
  EXPECT_EQ(upside_down.code, 1);
  EXPECT_CONTAINS(upside_down.output, "80 of 80 dropped (tilted)");
  EXPECT_CONTAINS(upside_down.output, "--imu none maps without the IMU");
  EXPECT_CONTAINS(map("35_mavros_tf_without_laser").output, "--laser-pose x,y,yaw");
}

}  // namespace
}  // namespace kestrel
