// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/filter/pose_filter_parameters.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <stdexcept>
#include <string>

namespace kestrel {
namespace {

/// Each test uses its own private namespace.
class PoseFilterParameters : public testing::Test {
 protected:
  PoseFilterParameters()
      : private_nh_(std::string("~") +
                    testing::UnitTest::GetInstance()->current_test_info()->name()) {}
  ~PoseFilterParameters() override { private_nh_.deleteParam(""); }

  ros::NodeHandle private_nh_;
};

TEST_F(PoseFilterParameters, DefaultsNeedNoParameters) {
  const PoseFilterNodeConfig config = loadPoseFilterParameters(private_nh_);
  EXPECT_EQ(config.odom_frame, "odom");
  EXPECT_EQ(config.filter.gate.max_reinitializations, 3);
}

TEST_F(PoseFilterParameters, TheInstalledFileContainsTheDefaults) {
  ASSERT_TRUE(ros::param::has("/shipped/gyro_bias_walk"));
  const PoseFilterNodeConfig config = loadPoseFilterParameters(ros::NodeHandle("/shipped"));
  EXPECT_EQ(config.filter.noise.gyro_bias_walk, ImuNoiseConfig().gyro_bias_walk);
}

TEST_F(PoseFilterParameters, OldNamesAreAccepted) {
  private_nh_.setParam("heading_sigma", 0.2);
  private_nh_.setParam("anchor_after", 3);
  private_nh_.setParam("max_anchors", 7);
  const PoseFilterNodeConfig config = loadPoseFilterParameters(private_nh_);
  EXPECT_EQ(config.filter.yaw_sigma_rad, 0.2);
  EXPECT_EQ(config.filter.gate.reinitialize_after_s, 3.0);
  EXPECT_EQ(config.filter.gate.max_reinitializations, 7);
}

TEST_F(PoseFilterParameters, TheNewNameHasPriority) {
  private_nh_.setParam("heading_sigma", 0.2);
  private_nh_.setParam("yaw_sigma", 0.3);
  EXPECT_EQ(loadPoseFilterParameters(private_nh_).filter.yaw_sigma_rad, 0.3);
}

TEST_F(PoseFilterParameters, ErrorsOfOldNamesShowTheNewOne) {
  private_nh_.setParam("max_anchors", 0);
  try {
    loadPoseFilterParameters(private_nh_);
    FAIL() << "nothing thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "max_reinitializations = 0: must be 1 or more");
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "pose_filter_parameters_test");
  ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
