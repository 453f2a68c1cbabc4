#include "kestrel_slam/tools/bag_flight_writer.h"

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace kestrel_slam {
namespace {

class BagFlightWriter : public testing::Test {
 protected:
  BagFlightWriter() {
    const SimulatedWorld& world = simulatedWorld("laboratory");
    LaserModel laser = laserModel("urg04lx");
    laser.rate_hz = 2.0;
    laser.dropout_probability = 0.0;  // no NaN, so that ranges can be compared
    flight_ = simulate(world.walls, laser, world.flight(), 4);
    mounting_ = laser.base_T_laser;
  }
  ~BagFlightWriter() override { std::filesystem::remove(path_); }

  std::vector<SimulatedScan> flight_;
  Pose2 mounting_;
  std::string path_ = testing::TempDir() + "kestrel_slam_flight.bag";
};

TEST_F(BagFlightWriter, writesWhatWasSimulated) {
  writeFlightBag(path_, flight_, mounting_);
  rosbag::Bag bag(path_, rosbag::bagmode::Read);
  std::size_t scans = 0, truths = 0;
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) {
      const LaserScan& expected = flight_.at(scans++).scan;
      EXPECT_NEAR(scan->header.stamp.toSec(), expected.stamp, 1e-6);
      EXPECT_EQ(scan->header.frame_id, "laser");
      EXPECT_NEAR(scan->angle_max, expected.angle_min + 681.0 * expected.angle_increment, 1e-6);
      EXPECT_EQ(scan->ranges, expected.ranges);
    } else if (const auto truth = message.instantiate<nav_msgs::Odometry>()) {
      const Pose2& expected = flight_.at(truths++).world_T_base;
      EXPECT_EQ(truth->pose.pose.position.x, expected.x);
      EXPECT_EQ(truth->pose.pose.position.y, expected.y);
      EXPECT_NEAR(2.0 * std::atan2(truth->pose.pose.orientation.z, truth->pose.pose.orientation.w),
                  expected.theta, 1e-9);
    }
  }
  EXPECT_EQ(scans, flight_.size());
  EXPECT_EQ(truths, flight_.size());
}

TEST_F(BagFlightWriter, staticTransformIsLatchedAndComplete) {
  writeFlightBag(path_, flight_, mounting_);
  rosbag::Bag bag(path_, rosbag::bagmode::Read);
  rosbag::View view(bag, rosbag::TopicQuery("/tf_static"));
  ASSERT_EQ(view.size(), 1U);
  const auto message = view.begin()->instantiate<tf2_msgs::TFMessage>();
  ASSERT_EQ(message->transforms.size(), 1U);
  EXPECT_EQ(message->transforms[0].header.frame_id, "base_link");
  EXPECT_EQ(message->transforms[0].child_frame_id, "laser");
  EXPECT_EQ(message->transforms[0].transform.translation.x, 0.08);
  // Readers in Python refuse a bag whose connection lacks one of these.
  const rosbag::ConnectionInfo& connection = *view.getConnections().at(0);
  for (const char* field : {"type", "md5sum", "message_definition"}) {
    EXPECT_EQ(connection.header->count(field), 1U) << field;
  }
  EXPECT_EQ(connection.header->at("latching"), "1");
}

TEST_F(BagFlightWriter, aFailureNamesTheFileAndLeavesNothing) {
  const std::string missing = testing::TempDir() + "no_such_folder/flight.bag";
  try {
    writeFlightBag(missing, flight_, mounting_);
    FAIL() << "accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(missing), std::string::npos) << error.what();
  }
  EXPECT_THROW(writeFlightBag(testing::TempDir(), flight_, mounting_), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(testing::TempDir() + ".part"));
}

}  // namespace
}  // namespace kestrel_slam
