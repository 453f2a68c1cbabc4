// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/latency/latency_record.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>

namespace kestrel {
namespace {

constexpr double kPause = 0.02;  // s

/// 11 beams, 1 ms apart.
LiveMessage scanAt(double stamp) {
  const auto scan = boost::make_shared<sensor_msgs::LaserScan>();
  scan->header.stamp = ros::Time(stamp);
  scan->time_increment = 0.001F;
  scan->ranges.resize(11);
  return scan;
}

LiveMessage imuAt(double stamp) {
  const auto imu = boost::make_shared<sensor_msgs::Imu>();
  imu->header.stamp = ros::Time(stamp);
  return imu;
}

void pause() { ros::WallDuration(kPause).sleep(); }

TEST(LatencyRecord, MeasuresFromTheScanAndFromItsLastImuMessage) {
  LatencyRecord record(true);
  record.sent(imuAt(10.0));
  record.sent(scanAt(10.0));  // its last beam is at 10.01
  pause();
  record.sent(imuAt(10.005));
  pause();
  record.sent(imuAt(10.015));
  pause();
  record.poseReceived(ros::Time(10.0));
  pause();
  record.poseReceived(ros::Time(10.0));  // only the first pose is used
  ASSERT_EQ(record.poses(), 1U);
  const double pause_ms = 1000.0 * kPause;
  EXPECT_GE(record.fromScan().front(), 3.0 * pause_ms);
  EXPECT_GE(record.fromLastInput().front(), pause_ms);
  EXPECT_LT(record.fromLastInput().front(), record.fromScan().front() - 1.9 * pause_ms);
}

TEST(LatencyRecord, ADroppedScanHadAllItsInputs) {
  LatencyRecord record(true);
  record.sent(imuAt(10.2));
  record.sent(scanAt(10.0));
  record.sent(scanAt(10.1));
  record.sent(scanAt(10.2));  // the IMU ends before its last beam
  record.poseReceived(ros::Time(10.1));
  record.poseReceived(ros::Time(99.0));  // belongs to no scan
  EXPECT_EQ(record.sentScans(), 3U);
  EXPECT_EQ(record.poses(), 1U);
  EXPECT_EQ(record.dropped(), 1U);
  EXPECT_EQ(record.incomplete(), 1U);
}

TEST(LatencyRecord, WithoutAnImuEveryScanIsComplete) {
  LatencyRecord record(false);
  record.sent(scanAt(10.0));
  EXPECT_EQ(record.dropped(), 1U);
  EXPECT_EQ(record.incomplete(), 0U);
}

TEST(LatencyRecord, MeasuresFromTheImuToTheStateWithTheSameStamp) {
  LatencyRecord record(true);
  record.sent(imuAt(10.0));
  record.sent(imuAt(10.1));
  pause();
  record.stateReceived(ros::Time(10.1));
  record.stateReceived(ros::Time(10.1));  // only the first state is used
  record.stateReceived(ros::Time(99.0));  // belongs to no message
  ASSERT_EQ(record.fromImu().size(), 1U);
  EXPECT_GE(record.fromImu().front(), 1000.0 * kPause);
}

TEST(Quantile, UsesTheNearestRank) {
  std::vector<double> values;
  for (int i = 1; i <= 200; ++i) values.push_back(i);
  EXPECT_EQ(quantile(values, 0.5), 100.0);
  EXPECT_EQ(quantile(values, 0.99), 198.0);
  EXPECT_EQ(quantile(values, 1.0), 200.0);
  EXPECT_EQ(quantile({3.0}, 0.0), 3.0);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
