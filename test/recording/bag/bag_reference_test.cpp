// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_reference.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>
#include <string>

#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/reference.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

geometry_msgs::Pose poseAt(double x, double yaw) {
  geometry_msgs::Pose pose;
  pose.position.x = x;
  pose.position.y = -x;
  pose.orientation.z = std::sin(yaw / 2.0);
  pose.orientation.w = std::cos(yaw / 2.0);
  return pose;
}

geometry_msgs::PoseStamped stamped(double stamp, double x, double yaw = 0.0) {
  geometry_msgs::PoseStamped message;
  message.header.stamp = ros::Time(stamp);
  message.pose = poseAt(x, yaw);
  return message;
}

nav_msgs::Odometry odometry(double stamp, double x) {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(stamp);
  message.child_frame_id = "base_link";
  message.pose.pose = poseAt(x, 0.0);
  return message;
}

class BagReferenceTest : public ::testing::Test {
 protected:
  rosbag::Bag& bag() {
    if (!bag_.isOpen()) bag_.open(path_, rosbag::bagmode::Write);
    return bag_;
  }
  Trajectory read(const std::string& topic = "") {
    if (bag_.isOpen()) bag_.close();
    return readReference(path_, topic);
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("a.bag");
  rosbag::Bag bag_;
};

TEST_F(BagReferenceTest, PosesAreSortedByHeaderStampWithoutDuplicates) {
  bag().write("/mocap", ros::Time(5.0), stamped(1.0, 10.0, 0.5));
  bag().write("/mocap", ros::Time(5.0), stamped(3.0, 30.0));  // a burst in wrong order
  bag().write("/mocap", ros::Time(5.0), stamped(2.0, 20.0));
  bag().write("/mocap", ros::Time(5.1), stamped(2.0, 21.0));  // repeated
  const Trajectory trajectory = read();
  ASSERT_EQ(trajectory.size(), 3U);
  EXPECT_EQ(trajectory[0].stamp, 1.0);
  EXPECT_EQ(trajectory[0].pose.x, 10.0);
  EXPECT_EQ(trajectory[0].pose.y, -10.0);
  EXPECT_NEAR(trajectory[0].pose.yaw, 0.5, 1e-12);
  EXPECT_EQ(trajectory[1].stamp, 2.0);
  EXPECT_EQ(trajectory[1].pose.x, 20.0);
  EXPECT_EQ(trajectory[2].stamp, 3.0);
}

TEST_F(BagReferenceTest, ReadsAllThreeTypes) {
  geometry_msgs::PoseWithCovarianceStamped with_covariance;
  with_covariance.header.stamp = ros::Time(2.0);
  with_covariance.pose.pose = poseAt(2.0, 0.0);
  bag().write("/a", ros::Time(1.0), stamped(1.0, 1.0));
  bag().write("/b", ros::Time(2.0), with_covariance);
  bag().write("/c", ros::Time(3.0), odometry(3.0, 3.0));
  EXPECT_EQ(read("/a").at(0).pose.x, 1.0);
  EXPECT_EQ(read("b").at(0).pose.x, 2.0);
  EXPECT_EQ(read("/c").at(0).pose.x, 3.0);
  EXPECT_CONTAINS(messageOf([&] { read(); }),
                  "a.bag: has several topics with poses; choose one "
                  "as reference: /a (geometry_msgs/PoseStamped, 1");
  EXPECT_CONTAINS(messageOf([&] { read("/d"); }), "a.bag: no topic /d of type geometry_msgs/Pose");
}

TEST_F(BagReferenceTest, InvalidPosesAreOmitted) {
  geometry_msgs::PoseStamped lost = stamped(1.0, 1.0);
  lost.pose.orientation = geometry_msgs::Quaternion();
  bag().write("/mocap", ros::Time(1.0), lost);
  bag().write("/mocap", ros::Time(2.0), stamped(2.0, std::nan("")));
  bag().write("/mocap", ros::Time(3.0), stamped(0.0, 1.0));
  EXPECT_CONTAINS(messageOf([&] { read(); }), "a.bag: topic /mocap has no usable pose");
  rosbag::Bag again(path_, rosbag::bagmode::Append);
  again.write("/mocap", ros::Time(4.0), stamped(4.0, 4.0));
  again.close();
  EXPECT_EQ(readReference(path_, "").size(), 1U);
}

TEST_F(BagReferenceTest, BagWithoutPosesListsItsTopics) {
  bag().write("/scan", ros::Time(1.0), sensor_msgs::LaserScan());
  EXPECT_CONTAINS(messageOf([&] { read(); }),
                  "has no topic with poses; its topics: /scan (sensor_msgs/LaserScan, 1 messages)");
}

TEST_F(BagReferenceTest, TextFileHasNoTopics) {
  const std::string path = folder_.write("a.tum", "1 2 3 0 0 0 0 1\n");
  EXPECT_EQ(readReference(path, "").at(0).pose.x, 2.0);
  EXPECT_CONTAINS(messageOf([&] { readReference(path, "/mocap"); }), "a.tum: is not a rosbag");
}

TEST_F(BagReferenceTest, GroundTruthIsOdometryOnlyOnRequest) {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = ros::Time(1.0);
  scan.header.frame_id = "base_link";
  scan.ranges = {1.0F};
  bag().write("/scan", ros::Time(1.0), scan);
  bag().write("/ground_truth", ros::Time(1.0), odometry(1.0, 1.0));
  bag().write("/gt/odom", ros::Time(1.0), odometry(1.0, 1.0));
  bag().close();
  const auto recording = openRecording(path_);
  EXPECT_FALSE(recording->hasOdometry());
  EXPECT_CONTAINS(recording->warnings().at(0),
                  "/ground_truth is ground truth, according to its name");
  EXPECT_CONTAINS(recording->warnings().at(1), "/gt/odom is ground truth, according to its name");

  rosbag::Bag more(path_, rosbag::bagmode::Append);
  more.write("/gtx/odom", ros::Time(1.0), odometry(1.0, 7.0));
  more.close();
  RecordedScan read_scan;
  const auto with_wheels = openRecording(path_);
  ASSERT_TRUE(with_wheels->next(read_scan));
  ASSERT_TRUE(read_scan.odom_T_base);
  EXPECT_EQ(read_scan.odom_T_base->x, 7.0);

  RecordingOptions options;
  options.odom_topic = "/ground_truth";
  const auto asked = openRecording(path_, options);
  EXPECT_TRUE(asked->hasOdometry());
  EXPECT_CONTAINS(asked->warnings().at(0), "the odometry /ground_truth is ground truth");
}

TEST(RealReferences, ReadMotionCapturePoses) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto check = [&](const std::string& name, const std::string& topic, std::size_t count) {
    const Trajectory trajectory = readReference(data + name, topic);
    EXPECT_EQ(trajectory.size(), count) << name;
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
      ASSERT_GT(trajectory[i].stamp, trajectory[i - 1].stamp);
      const Pose2 step = trajectory[i - 1].pose.inverse() * trajectory[i].pose;
      ASSERT_LT(step.distance(), 0.5) << name << " at " << trajectory[i].stamp;
    }
  };
  check("/moving/overtakes.bag", "/ego_pose", 3161);
  check("/moving/parallel.bag", "/ego_pose", 2034);
  check("/moving/two_robots.bag", "/mocap_pose", 1896);
}

}  // namespace
}  // namespace kestrel
