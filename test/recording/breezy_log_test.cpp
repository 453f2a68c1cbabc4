// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/breezy_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "recording/read_all.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kWheelRadius = 0.077, kAxle = 0.33;  // m

std::string lineOf(long time_us, int left, int right, std::size_t ranges = 682) {
  std::string line = std::to_string(time_us) + " 7 " + std::to_string(left) + ' ' +
                     std::to_string(right) + " 0.25";
  for (int i = 5; i < 24; ++i) line += " 9";
  for (std::size_t i = 0; i < ranges; ++i) line += ' ' + std::to_string(i * 5);
  return line + " \n";
}

TEST(BreezyLog, ReadsTimeRangesAndMounting) {
  const TemporaryFolder folder;
  const auto recording = openRecording(folder.write("a.dat", lineOf(361431443, 5, 6)));
  EXPECT_EQ(recording->scanCount(), 1U);
  EXPECT_TRUE(recording->hasOdometry());
  EXPECT_EQ(recording->description(), "BreezySLAM log, 1 scans of a URG-04LX, with wheel odometry");
  const RecordedScan recorded = readAll(*recording).at(0);
  const LaserScan& scan = recorded.scan;
  EXPECT_EQ(scan.stamp, 361.431443);
  EXPECT_EQ(recorded.time, 361.431443);
  ASSERT_EQ(scan.ranges.size(), 682U);
  EXPECT_TRUE(std::isnan(scan.ranges[0]));
  EXPECT_EQ(scan.ranges[1], 0.005F);
  EXPECT_EQ(scan.ranges[681], 3.405F);
  EXPECT_NEAR(scan.angle_increment, degToRad(0.3515625), 1e-12);
  EXPECT_NEAR(scan.angle_min, -340.5 * scan.angle_increment, 1e-12);
  EXPECT_EQ(recorded.base_T_laser.translation(), Eigen::Vector3d(0.145, 0.0, 0.0));
}

TEST(BreezyLog, OneTurnOfBothWheelsDrivesTheirCircumference) {
  const TemporaryFolder folder;
  const auto recording =
      openRecording(folder.write("a.dat", lineOf(100000, 500, 900) + lineOf(200000, 2500, 2900)));
  const std::vector<RecordedScan> scans = readAll(*recording);
  EXPECT_EQ(*scans.at(0).odom_T_base, Pose2());
  EXPECT_NEAR(scans.at(1).odom_T_base->x, 2.0 * kPi * kWheelRadius, 1e-12);
  EXPECT_NEAR(scans.at(1).odom_T_base->y, 0.0, 1e-12);
  EXPECT_NEAR(scans.at(1).odom_T_base->yaw, 0.0, 1e-12);
}

TEST(BreezyLog, RightWheelTurnsTheVehicleToTheLeft) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i <= 2000; ++i) text += lineOf(100000 * (i + 1L), 0, i);
  const std::vector<RecordedScan> scans = readAll(*openRecording(folder.write("a.dat", text)));
  // Many small steps follow the arc around the left wheel.
  const double angle = 2.0 * kPi * kWheelRadius / kAxle;
  const Pose2& end = *scans.back().odom_T_base;
  EXPECT_NEAR(end.yaw, angle, 1e-9);
  EXPECT_NEAR(end.x, kAxle / 2.0 * std::sin(angle), 1e-6);
  EXPECT_NEAR(end.y, kAxle / 2.0 * (1.0 - std::cos(angle)), 1e-6);
}

TEST(BreezyLog, BrokenLinesAreSkippedAndCounted) {
  const TemporaryFolder folder;
  const auto recording = openRecording(
      folder.write("a.dat", lineOf(100000, 0, 0) + "1 2 3\n" + lineOf(200000, 0, 0, 700) + "x" +
                                lineOf(300000, 0, 0) + lineOf(400000, 0, 0, 683) + "\n"));
  EXPECT_EQ(recording->scanCount(), 5U);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[1].scan.stamp, 0.4);
  EXPECT_EQ(scans[1].scan.ranges.size(), 682U);
  EXPECT_EQ(recording->skipped().at("broken line"), 3U);
  EXPECT_CONTAINS(recording->warnings().at(0), "line 2: broken line skipped");
}

TEST(BreezyLog, DamagedDigitsOfTheWheelsAndSplitNumbersAreSkipped) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 20; ++i) {
    std::string line = lineOf(100000 * (i + 1L), 20000 + 10 * i, 20000 + 10 * i);
    if (i == 7) line.replace(line.find("20070"), 5, "60070");
    if (i == 9) line.replace(line.find(" 1000 "), 6, " 1 00 ");
    text += line;
  }
  const auto recording = openRecording(folder.write("a.dat", text));
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 18U);
  EXPECT_EQ(recording->skipped().at("broken line"), 2U);
  EXPECT_NEAR(scans.back().odom_T_base->x, 2.0 * kPi * kWheelRadius * 190.0 / 2000.0, 1e-9);
}

TEST(BreezyLog, EncodersThatStartAgainAreFollowed) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 10; ++i) text += lineOf(100000 * (i + 1L), 90000 + 100 * i, 90000 + 100 * i);
  for (int i = 10; i < 20; ++i) text += lineOf(100000 * (i + 1L), 100 * i, 100 * i);
  const std::vector<RecordedScan> scans = readAll(*openRecording(folder.write("a.dat", text)));
  ASSERT_EQ(scans.size(), 19U);
  EXPECT_NEAR(scans.back().odom_T_base->x, 2.0 * kPi * kWheelRadius * 1700.0 / 2000.0, 1e-9);
}

TEST(RealBreezyLog, DriveInTheMinesIsPlausible) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto recording = openRecording(data + "/mav/urg04lx_mines_exp2.dat");
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 641U);
  EXPECT_TRUE(recording->warnings().empty());
  double path = 0.0;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    const Pose2 step = scans[i - 1].odom_T_base->inverse() * *scans[i].odom_T_base;
    path += step.distance();
    EXPECT_LT(step.distance(),
              3.0 * (scans[i].time - scans[i - 1].time));  // largest plausible speed
    EXPECT_GT(scans[i].time, scans[i - 1].time);
  }
  EXPECT_GT(path, 20.0);
  EXPECT_LT(path, 80.0);
}

}  // namespace
}  // namespace kestrel
