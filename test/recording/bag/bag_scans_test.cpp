// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_scans.h"

#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "bag_maker.h"
#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

using BagScansTest = BagTest;

void recordSegments(rosbag::Bag& bag, std::size_t turns, std::size_t beams,
                    const std::string& topic = "/segment", const std::string& frame = "laser") {
  for (std::size_t first = 0; first < 360 * turns; first += beams) {
    const auto scan = turnPart(first, beams, frame);
    record(bag, topic, scan.header.stamp.toSec() + 0.01, scan);
  }
}

TEST_F(BagScansTest, SegmentsOfATurnAreJoined) {
  const auto recording = open([](rosbag::Bag& bag) { recordSegments(bag, 10, 30); });
  EXPECT_EQ(recording->scanCount(), 10U);
  EXPECT_CONTAINS(recording->description(), "(each joined from 12 messages)");
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 10U);
  EXPECT_EQ(scans[3].scan.ranges, turnPart(0, 360).ranges);
  EXPECT_NEAR(scans[3].scan.stamp, kBagStart + 0.3, 1e-6);
}

TEST_F(BagScansTest, SegmentsOfSeveralFramesAreKeptApart) {
  const auto recording = open([](rosbag::Bag& bag) {
    for (std::size_t first = 0; first < 3600; first += 30) {
      for (const char* frame : {"echo_0", "echo_1", "echo_2"}) {
        const auto scan = turnPart(first, 30, frame);
        record(bag, "/segment", scan.header.stamp.toSec() + 0.01, scan);
      }
    }
    for (const char* frame : {"echo_0", "echo_1", "echo_2"}) {
      record(bag, "/tf_static", kBagStart, transform("base_link", frame, kBagStart, 0.0));
    }
  });
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 30U);
  for (const RecordedScan& scan : scans) EXPECT_EQ(scan.scan.ranges.size(), 360U);
}

TEST_F(BagScansTest, TopicsAreRankedByWhatTheySee) {
  // The depth camera has more messages and more beams, but sees less than the laser.
  const auto recording = open([](rosbag::Bag& bag) {
    recordTurns(bag, 5, "laser", "/z_scan");
    for (std::size_t i = 0; i < 30; ++i) {
      auto narrow = turnPart(0, 640, "camera");
      narrow.angle_increment = 0.0016F;
      narrow.range_max = 10.0F;
      narrow.header.stamp = ros::Time(kBagStart + 0.03 * static_cast<double>(i));
      record(bag, "/depth_scan", narrow.header.stamp.toSec(), narrow);
    }
  });
  EXPECT_CONTAINS(recording->description(), "5 scans on /z_scan");
  EXPECT_CONTAINS(warningsOf(*recording),
                  "the one that sees most is used: /z_scan; topics: /z_scan (359 deg, 360 beams, "
                  "12 m); /depth_scan (59 deg, 640 beams, 10 m)");
}

TEST_F(BagScansTest, ATopicOfSegmentsBesideOneOfFullTurnsChangesNothing) {
  const auto recording = open([](rosbag::Bag& bag) {
    recordSegments(bag, 8, 30, "/a_segment");
    recordTurns(bag, 8, "laser", "/b_full");
  });
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 8U);
  for (const RecordedScan& scan : scans) EXPECT_EQ(scan.scan.ranges.size(), 360U);
}

TEST_F(BagScansTest, ALevelLaserIsPreferredToAVerticalOne) {
  const auto recording = open([](rosbag::Bag& bag) {
    tf2_msgs::TFMessage vertical = transform("base_link", "vertical", kBagStart, 0.0);
    vertical.transforms[0].transform.rotation.x = std::sqrt(0.5);
    vertical.transforms[0].transform.rotation.w = std::sqrt(0.5);
    record(bag, "/tf_static", kBagStart, vertical);
    record(bag, "/tf_static", kBagStart, transform("base_link", "horizontal", kBagStart, 0.0));
    recordTurns(bag, 6, "vertical", "/a");
    recordTurns(bag, 5, "horizontal", "/b");
  });
  EXPECT_CONTAINS(recording->description(), "5 scans on /b");
}

TEST_F(BagScansTest, TheStrongestEchoIsUsed) {
  sensor_msgs::MultiEchoLaserScan scan;
  scan.ranges.resize(4);
  scan.intensities.resize(3);
  scan.ranges[0].echoes = {1.0F, 2.0F, 3.0F};
  scan.intensities[0].echoes = {5.0F, 9.0F, 7.0F};
  scan.ranges[1].echoes = {1.0F, 2.0F};
  scan.intensities[1].echoes = {0.0F, 0.0F};
  scan.ranges[3].echoes = {4.0F, 6.0F};
  const LaserScan content = fromMessage(scan);
  ASSERT_EQ(content.ranges.size(), 4U);
  EXPECT_EQ(content.ranges[0], 2.0F);
  EXPECT_EQ(content.ranges[1], 2.0F) << "of equal intensities: the last";
  EXPECT_TRUE(std::isnan(content.ranges[2])) << "no echo";
  EXPECT_EQ(content.ranges[3], 6.0F) << "without intensities: the last";
}

TEST_F(BagScansTest, MultiEchoLaserScansAreRead) {
  const auto recording = open([](rosbag::Bag& bag) {
    for (int i = 0; i < 4; ++i) {
      const auto source = turnPart(static_cast<std::size_t>(360 * i), 360);
      sensor_msgs::MultiEchoLaserScan scan;
      scan.header = source.header;
      scan.angle_min = source.angle_min;
      scan.angle_increment = source.angle_increment;
      scan.range_max = source.range_max;
      scan.ranges.resize(source.ranges.size());
      for (std::size_t k = 0; k < source.ranges.size(); ++k) {
        scan.ranges[k].echoes = {0.5F, source.ranges[k]};
      }
      record(bag, "/echoes", kBagStart + 0.1 * i, scan);
    }
  });
  EXPECT_CONTAINS(recording->description(), "4 scans on /echoes");
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_EQ(scans[0].scan.ranges, turnPart(0, 360).ranges);
}

TEST_F(BagScansTest, PointCloudsOfTheOldTypeAreReadWithTheirTimes) {
  const auto recording = open([](rosbag::Bag& bag) {
    for (int i = 0; i < 4; ++i) {
      sensor_msgs::PointCloud cloud;
      cloud.header.stamp = ros::Time(kBagStart + 0.1 * i);
      cloud.header.frame_id = "lidar";
      cloud.channels.resize(2);
      cloud.channels[0].name = "intensity";
      cloud.channels[1].name = "time";
      for (int k = 0; k < 100; ++k) {
        geometry_msgs::Point32 point;
        point.x = static_cast<float>(3.0 * std::cos(0.0628 * k));
        point.y = static_cast<float>(3.0 * std::sin(0.0628 * k));
        cloud.points.push_back(point);
        cloud.channels[1].values.push_back(1000.0F * static_cast<float>(k));  // µs
      }
      record(bag, "/cloud", kBagStart + 0.1 * i, cloud);
    }
  });
  EXPECT_CONTAINS(recording->description(), "4 clouds on /cloud");
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_EQ(scans[0].cloud->points.at(0).x, 3.0F);
  EXPECT_NEAR(scans[0].cloud->points.at(99).time, 0.099, 1e-6);
}

/// Columns of a lidar that turns ten times per second, as one packet.
sensor_msgs::PointCloud2 packet(int first, int count) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = ros::Time(kBagStart + first * 0.1 / 360.0);
  cloud.header.frame_id = "velodyne";
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(static_cast<std::size_t>(count));
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (int i = first; i < first + count; ++i, ++x, ++y, ++z) {
    *x = static_cast<float>(5.0 * std::cos(degToRad(i)));
    *y = static_cast<float>(5.0 * std::sin(degToRad(i)));
    *z = 0.0F;
  }
  return cloud;
}

TEST_F(BagScansTest, PacketsOfATurnAreJoined) {
  const auto recording = open([](rosbag::Bag& bag) {
    for (int first = 0; first < 5 * 360; first += 12) {
      const auto cloud = packet(first, 12);
      record(bag, "/packets", cloud.header.stamp.toSec(), cloud);
    }
  });
  EXPECT_EQ(recording->scanCount(), 5U);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 5U);
  EXPECT_EQ(scans[2].cloud->points.size(), 360U);
  EXPECT_NEAR(scans[2].cloud->points.back().time, 0.0967, 1e-3);
}

}  // namespace
}  // namespace kestrel
