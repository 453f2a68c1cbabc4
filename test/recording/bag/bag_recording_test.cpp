// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_recording.h"

#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <vector>

#include "bag_maker.h"
#include "kestrel_slam/recording/bag/bag_writer.h"
#include "kestrel_slam/recording/carmen_log.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

sensor_msgs::LaserScan scanAt(double stamp, const std::string& frame = "laser") {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = ros::Time(stamp);
  scan.header.frame_id = frame;
  scan.angle_min = -0.5F;
  scan.angle_increment = 0.25F;
  scan.time_increment = 0.001F;
  scan.range_min = 0.1F;
  scan.range_max = 10.0F;
  scan.ranges = {1.0F, std::numeric_limits<float>::infinity(), 3.0F};
  return scan;
}

nav_msgs::Odometry odometryAt(double stamp, double x) {
  nav_msgs::Odometry odometry;
  odometry.header.stamp = ros::Time(stamp);
  odometry.child_frame_id = "base_link";
  odometry.pose.pose.position.x = x;
  odometry.pose.pose.orientation.w = 1.0;
  return odometry;
}

class BagRecordingTest : public ::testing::Test {
 protected:
  std::string writeBag(const std::function<void(rosbag::Bag&)>& fill) {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    fill(bag);
    bag.close();
    return path_;
  }

  static std::vector<RecordedScan> readAll(Recording& recording) {
    std::vector<RecordedScan> scans;
    RecordedScan scan;
    while (recording.next(scan)) scans.push_back(scan);
    return scans;
  }

  std::string problem(const RecordingOptions& options = RecordingOptions()) {
    return messageOf([&] { openRecording(path_, options); });
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("a.bag");
};

template <typename Message>
void record(rosbag::Bag& bag, const std::string& topic, double time, const Message& message) {
  bag.write(topic, ros::Time(time), message);
}

TEST_F(BagRecordingTest, ReadsEveryFieldOfAScan) {
  writeBag([](rosbag::Bag& bag) { record(bag, "/scan", 5.0, scanAt(4.75)); });
  const auto recording = openRecording(path_);
  EXPECT_EQ(recording->scanCount(), 1U);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 1U);
  const LaserScan& scan = scans[0].scan;
  EXPECT_EQ(scan.stamp, 4.75);
  EXPECT_EQ(scans[0].time, 4.75);
  EXPECT_EQ(scan.angle_min, -0.5);
  EXPECT_EQ(scan.angle_increment, 0.25);
  EXPECT_EQ(scan.time_increment, 0.001F);
  EXPECT_EQ(scan.range_min, 0.1F);
  EXPECT_EQ(scan.range_max, 10.0);
  EXPECT_EQ(scan.ranges, (std::vector<float>{1.0F, std::numeric_limits<float>::infinity(), 3.0F}));
}

TEST_F(BagRecordingTest, WithoutTfTheLaserIsTheBase) {
  writeBag([](rosbag::Bag& bag) { record(bag, "/scan", 5.0, scanAt(5.0)); });
  const auto recording = openRecording(path_);
  EXPECT_TRUE(readAll(*recording).at(0).base_T_laser.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_FALSE(recording->hasOdometry());
  ASSERT_EQ(recording->warnings().size(), 1U);
  EXPECT_CONTAINS(recording->warnings()[0], "no tf");
}

TEST_F(BagRecordingTest, UsesMountingAndOdometryFromTf) {
  writeBag([](rosbag::Bag& bag) {
    record(bag, "/tf_static", 1.0, transform("/base_link", "/laser", 1.0, 0.2, kPi));
    record(bag, "/tf", 2.0, transform("/odom", "/base_link", 2.0, 1.0, 0.0));
    record(bag, "/scan", 2.5, scanAt(2.25, "/laser"));
    record(bag, "/tf", 3.0, transform("/odom", "/base_link", 3.0, 2.0, 0.4));
  });
  const auto recording = openRecording(path_);
  EXPECT_TRUE(recording->hasOdometry());
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_NEAR(scans[0].base_T_laser.translation().x(), 0.2, 1e-12);
  EXPECT_NEAR(scans[0].base_T_laser.linear()(0, 0), -1.0, 1e-12);
  ASSERT_TRUE(scans[0].odom_T_base);
  EXPECT_NEAR(scans[0].odom_T_base->x, 1.25, 1e-9);
  EXPECT_NEAR(scans[0].odom_T_base->yaw, 0.1, 1e-9);
  EXPECT_TRUE(recording->warnings().empty());
}

TEST_F(BagRecordingTest, UsesTheOnlyOdometryTopic) {
  writeBag([](rosbag::Bag& bag) {
    record(bag, "/tf_static", 1.0, transform("base_link", "laser", 1.0, 0.2));
    record(bag, "/wheels", 2.0, odometryAt(2.0, 1.0));
    record(bag, "/scan", 2.1, scanAt(2.1));
    record(bag, "/wheels", 2.4, odometryAt(2.4, 3.0));
    record(bag, "/scan", 9.0, scanAt(9.0));
  });
  const auto recording = openRecording(path_);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 2U);
  ASSERT_TRUE(scans[0].odom_T_base);
  EXPECT_NEAR(scans[0].odom_T_base->x, 1.5, 1e-9);
  EXPECT_FALSE(scans[1].odom_T_base);
  ASSERT_EQ(recording->warnings().size(), 1U);
  EXPECT_CONTAINS(recording->warnings()[0], "no odometry at the times of some scans");
}

TEST_F(BagRecordingTest, ConstantMountingIsValidAtAnyTime) {
  writeBag([](rosbag::Bag& bag) {
    record(bag, "/scan", 1.0, scanAt(1.0));
    record(bag, "/tf", 5.0, transform("base_link", "laser", 5.0, 0.2));
    record(bag, "/tf", 6.0, transform("base_link", "laser", 6.0, 0.2));
  });
  EXPECT_NEAR(readAll(*openRecording(path_)).at(0).base_T_laser.translation().x(), 0.2, 1e-12);
}

TEST_F(BagRecordingTest, SkipsAndCountsScansWithoutTransform) {
  writeBag([](rosbag::Bag& bag) {
    record(bag, "/tf_static", 1.0, transform("base_link", "imu", 1.0, 0.2));
    for (int i = 2; i < 5; ++i) record(bag, "/scan", i, scanAt(i, "laser_7"));
  });
  const auto recording = openRecording(path_);
  EXPECT_TRUE(readAll(*recording).empty());
  EXPECT_EQ(recording->skipped(), (std::map<std::string, std::size_t>{{"missing transform", 3}}));
  ASSERT_EQ(recording->warnings().size(), 1U);
  EXPECT_CONTAINS(recording->warnings()[0], "base_link -> laser_7");
  EXPECT_CONTAINS(recording->warnings()[0], "give the mounting with --laser-pose x,y,yaw");
}

TEST_F(BagRecordingTest, OfEqualLasersTheOneWithMostScansIsUsedAndTheOthersAreListed) {
  writeBag([](rosbag::Bag& bag) {
    record(bag, "/rear", 1.0, scanAt(1.0));
    record(bag, "/front", 1.0, scanAt(1.0));
    record(bag, "/front", 2.0, scanAt(2.0));
  });
  const auto recording = openRecording(path_);
  EXPECT_EQ(recording->scanCount(), 2U);
  EXPECT_CONTAINS(recording->warnings().at(0),
                  "/front; topics: /front (29 deg, 3 beams, 10 m); /rear (29 deg, ");
  RecordingOptions options;
  options.scan_topic = "rear";
  EXPECT_EQ(openRecording(path_, options)->scanCount(), 1U);
  options.scan_topic = "/side";
  EXPECT_CONTAINS(problem(options), "no topic /side of type sensor_msgs/LaserScan");
}

TEST_F(BagRecordingTest, ScansWithoutStampGetTheRecordTime) {
  writeBag([](rosbag::Bag& bag) { record(bag, "/scan", 7.5, scanAt(0.0)); });
  EXPECT_EQ(readAll(*openRecording(path_)).at(0).scan.stamp, 7.5);
}

TEST_F(BagRecordingTest, StampsThatJumpBackAreRead) {
  writeBag([](rosbag::Bag& bag) {
    for (int i = 0; i < 200; ++i) record(bag, "/scan", 100.0 + i, scanAt(50.0 + i % 100));
  });
  const std::vector<RecordedScan> scans = readAll(*openRecording(path_));
  ASSERT_EQ(scans.size(), 200U);
  for (std::size_t i = 1; i < scans.size(); ++i) EXPECT_GT(scans[i].time, scans[i - 1].time);
  EXPECT_EQ(scans[150].scan.stamp, 100.0);
}

TEST_F(BagRecordingTest, BagWithoutLaserListsItsTopics) {
  writeBag([](rosbag::Bag& bag) {
    std_msgs::String text;
    record(bag, "/chatter", 1.0, text);
  });
  EXPECT_CONTAINS(problem(), "a.bag: has no sensor_msgs/LaserScan");
  EXPECT_CONTAINS(problem(), "/chatter (std_msgs/String, 1 messages)");
}

TEST_F(BagRecordingTest, DifferentVersionOfTheMessageIsAnError) {
  writeBag([](rosbag::Bag& bag) {
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["topic"] = "/scan";
    (*header)["type"] = "sensor_msgs/LaserScan";
    (*header)["md5sum"] = "0123456789abcdef0123456789abcdef";
    (*header)["message_definition"] = "string data";
    bag.write("/scan", ros::Time(1.0), std_msgs::String(), header);
  });
  EXPECT_CONTAINS(problem(), "topic /scan has a different version of sensor_msgs/LaserScan");
}

TEST_F(BagRecordingTest, CutOffBagSuggestsReindex) {
  writeBag([](rosbag::Bag& bag) {
    bag.setChunkThreshold(1000);
    for (int i = 1; i < 500; ++i) record(bag, "/scan", i, scanAt(i));
  });
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  EXPECT_CONTAINS(problem(), "rosbag reindex " + path_);
  folder_.write("a.bag", "#ROSBAG V2.0\n");
  EXPECT_CONTAINS(problem(), "a.bag: is not a valid bag");
  folder_.write("a.bag", "#ROSBAG V2.0\n" + std::string(10000, 'x'));
  EXPECT_CONTAINS(problem(), "a.bag: ");
}

TEST_F(BagRecordingTest, DamagedBytesDoNotCrash) {
  writeBag([](rosbag::Bag& bag) {
    for (int i = 1; i < 50; ++i) record(bag, "/scan", i, scanAt(i));
  });
  std::ostringstream content;
  content << std::ifstream(path_, std::ios::binary).rdbuf();
  const std::string good = content.str();
  for (std::size_t position = 13; position < good.size(); position += 97) {
    std::string bad = good;
    for (std::size_t i = position; i < std::min(position + 8, bad.size()); ++i) bad[i] = '\x7f';
    folder_.write("a.bag", bad);
    try {
      EXPECT_LE(readAll(*openRecording(path_)).size(), 49U);
    } catch (const std::runtime_error& error) {
      EXPECT_CONTAINS(error.what(), "a.bag: ");
    }
  }
}

TEST_F(BagRecordingTest, ConvertedLogGivesTheSameScansAsTheLog) {
  std::string text = "PARAM robot_frontlaser_offset -0.04 h 0\n";
  const double stamps[] = {10.125001, 10.3, 10.2, 10.5};  // the third stamp jumps back
  for (int i = 0; i < 4; ++i) {
    text += "FLASER 3 1 2.5 81.91 0 0 0 " + std::to_string(0.1 * i) + " 0.25 " +
            std::to_string(3.0 - i) + ' ' + std::to_string(stamps[i]) + " h 0\n";
  }
  const std::string log_path = folder_.write("a.clf", text);
  CarmenLog source(log_path), expected(log_path);
  EXPECT_EQ(kestrel::writeBag(path_, source, BagStamps::kRecorded).scans, 4U);
  const auto bag = openRecording(path_);
  EXPECT_EQ(bag->description(),
            "rosbag, 4 scans on /scan, laser laser on base_link, odometry /odom");
  RecordedScan a, b;
  while (expected.next(a)) {
    ASSERT_TRUE(bag->next(b));
    EXPECT_EQ(a.scan.stamp, b.scan.stamp);
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.scan.ranges, b.scan.ranges);
    EXPECT_EQ(a.scan.angle_min, b.scan.angle_min);
    EXPECT_EQ(a.scan.angle_increment, b.scan.angle_increment);
    EXPECT_EQ(a.scan.range_max, b.scan.range_max);
    EXPECT_TRUE(a.base_T_laser.isApprox(b.base_T_laser, 1e-12));
    EXPECT_LT((a.odom_T_base->inverse() * *b.odom_T_base).distance(), 1e-12);
    EXPECT_LT(std::abs((a.odom_T_base->inverse() * *b.odom_T_base).yaw), 1e-12);
  }
  EXPECT_FALSE(bag->next(b));
}

TEST_F(BagRecordingTest, UnwritableBagIsAnErrorAndLeavesNoFile) {
  CarmenLog log(folder_.write("a.clf", "FLASER 1 1 0 0 0 0 0 0 5 h 0\n"));
  const std::string path = folder_.file("no/a.bag");
  EXPECT_CONTAINS(messageOf([&] { kestrel::writeBag(path, log, BagStamps::kMonotone); }),
                  "no/a.bag: cannot be written");
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(RealBags, HaveTheExpectedScansAndMountings) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto check = [&](const std::string& name, std::size_t count, double laser_x) {
    const auto recording = openRecording(data + name);
    EXPECT_EQ(recording->scanCount(), count) << name;
    RecordedScan scan;
    std::size_t read = 0;
    for (; recording->next(scan); ++read) {
      EXPECT_NEAR(scan.base_T_laser.translation().x(), laser_x, 1e-3) << name;
    }
    EXPECT_EQ(read, count) << name;
  };
  check("/mav/handheld_urg04lx.bag", 360, 0.0);
  check("/moving/overtakes.bag", 339, 0.0);
  check("/moving/parallel.bag", 219, 0.0);
  check("/moving/two_robots.bag", 388, -0.139);
  check("/moving/people_wheelchair.bag", 873, 0.850);
}

}  // namespace
}  // namespace kestrel
