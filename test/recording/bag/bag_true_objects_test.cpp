// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/PoseStamped.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "bag_maker.h"
#include "kestrel_slam/recording/true_objects.h"

namespace kestrel {
namespace {

geometry_msgs::PoseStamped captured(double time, double x, double y, double yaw = 0.0) {
  geometry_msgs::PoseStamped message;
  message.header.stamp = ros::Time(time);
  message.pose.position.x = x;
  message.pose.position.y = y;
  message.pose.orientation.z = std::sin(yaw / 2.0);
  message.pose.orientation.w = std::cos(yaw / 2.0);
  return message;
}

class BagTrueObjectsTest : public BagTest {
 protected:
  /// A sensor that looks to the left and moves forward by 1 m/s, and two objects that stand.
  void SetUp() override {
    writeBag(
        [](rosbag::Bag& bag) {
          for (const double t : {0.0, 0.05, 0.1}) {
            const double time = kBagStart + t;
            record(bag, "/sensor", time, captured(time, t, 0.0, kPi / 2.0));
          }
          record(bag, "/first", kBagStart + 0.07, captured(kBagStart + 0.07, 2.0, 0.0));
          record(bag, "/second", kBagStart + 0.02, captured(kBagStart + 0.02, 0.02, 3.0));
          record(bag, "/second", kBagStart + 0.5, captured(kBagStart + 0.5, 0.0, 3.0));
        },
        path_);
  }

  std::string problemOf(const std::vector<std::string>& topics, const std::string& sensor) {
    try {
      readTrueObjects(path_, topics, sensor);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(BagTrueObjectsTest, EachTopicIsAnObjectInTheFrameOfTheSensor) {
  const auto objects = readTrueObjects(path_, {"/first", "/second"}, "/sensor");
  ASSERT_EQ(objects.size(), 2U) << "at 0.5 s the pose of the sensor is not known";
  EXPECT_EQ(objects[0].id, 2);
  EXPECT_NEAR(objects[0].stamp, kBagStart + 0.02, 1e-6);
  EXPECT_LT((objects[0].position - Eigen::Vector2d(3.0, 0.0)).norm(), 1e-6);
  EXPECT_EQ(objects[1].id, 1);
  EXPECT_LT((objects[1].position - Eigen::Vector2d(0.0, -1.93)).norm(), 1e-6);
}

TEST_F(BagTrueObjectsTest, WrongTopicsAreNamed) {
  EXPECT_NE(problemOf({"/third"}, "/sensor").find("/third"), std::string::npos);
  EXPECT_EQ(problemOf({}, "/sensor"), path_ + ": a topic of the poses of an object is needed");
  EXPECT_EQ(problemOf({"/first", "/second"}, ""),
            path_ + ": several topics need one with the poses of the sensor");
  EXPECT_NE(problemOf({}, "").find("leg_tracker/Person"), std::string::npos);
}

}  // namespace
}  // namespace kestrel
