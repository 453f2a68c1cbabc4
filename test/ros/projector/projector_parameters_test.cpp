// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/projector_parameters.h"

#include <gtest/gtest.h>
#include <ros/console.h>
#include <ros/ros.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/names.h"

namespace kestrel {
namespace {

/// Each test uses its own private namespace.
class ProjectorParameters : public testing::Test {
 protected:
  ProjectorParameters()
      : private_nh_(std::string("~") +
                    testing::UnitTest::GetInstance()->current_test_info()->name()) {}
  ~ProjectorParameters() override { private_nh_.deleteParam(""); }

  std::string errorOfLoading() const {
    try {
      loadProjectorParameters(private_nh_);
      return "";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }

  ros::NodeHandle private_nh_;
};

struct Outcome {
  int exit_code;
  std::string output;
};

/// Runs the node with an argument to its end, or for `seconds`.
Outcome runNode(const std::string& argument, int seconds) {
  const std::string command = "timeout -s INT " + std::to_string(seconds) +
                              " " KESTREL_SCAN_PROJECTOR_NODE " __name:=parameters " + argument +
                              " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  Outcome outcome{-1, ""};
  if (pipe == nullptr) return outcome;
  std::array<char, 1000> buffer{};
  while (fgets(buffer.data(), buffer.size(), pipe) != nullptr) outcome.output += buffer.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  ros::param::del("/parameters");
  return outcome;
}

void expectIn(const std::string& text, const std::string& whole) {
  EXPECT_NE(whole.find(text), std::string::npos) << whole;
}

TEST_F(ProjectorParameters, DefaultsNeedNoParameters) {
  const ProjectorNodeConfig config = loadProjectorParameters(private_nh_);
  EXPECT_EQ(config.base_frame, "base_link");
  EXPECT_EQ(config.base_stabilized_frame, "base_stabilized");
  EXPECT_EQ(config.attitude_frame, "base_stabilized");
  EXPECT_EQ(splitNames(config.scan_topics), std::vector<std::string>{"scan"});
  EXPECT_EQ(config.max_wait_s, 0.1);
  EXPECT_TRUE(config.usesImu());
  EXPECT_FALSE(config.hasMirror());
}

TEST_F(ProjectorParameters, AreReadWithTheirTypes) {
  private_nh_.setParam("base_stabilized_frame", "/level");  // as tf1 wrote it
  private_nh_.setParam("scan_topics", std::vector<std::string>{"front", "back"});
  private_nh_.setParam("attitude_source", "raw");
  private_nh_.setParam("max_wait", 1);
  private_nh_.setParam("max_tilt", 0.5);
  const ProjectorNodeConfig config = loadProjectorParameters(private_nh_);
  EXPECT_EQ(config.base_stabilized_frame, "level");
  EXPECT_EQ(config.attitude_frame, "level");
  EXPECT_EQ(splitNames(config.scan_topics), (std::vector<std::string>{"front", "back"}));
  EXPECT_EQ(config.slam.attitude.source, "raw");
  EXPECT_EQ(config.max_wait_s, 1.0);
  EXPECT_EQ(config.slam.projector.max_tilt_rad, 0.5);
}

TEST_F(ProjectorParameters, TopicsWithCommas) {
  EXPECT_EQ(splitNames("front, back,,front "), (std::vector<std::string>{"front", "back"}));
  EXPECT_TRUE(splitNames(" , ").empty());
}

TEST_F(ProjectorParameters, ErrorsListTheChoices) {
  private_nh_.setParam("attitude_source", "gps");
  const std::string error = errorOfLoading();
  expectIn("attitude_source = gps", error);
  expectIn("auto, orientation, raw, tf, none", error);
}

TEST_F(ProjectorParameters, FramesMustDiffer) {
  private_nh_.setParam("base_stabilized_frame", "base_link");
  expectIn("base_stabilized_frame = base_link", errorOfLoading());
}

TEST_F(ProjectorParameters, OneLaserTopicIsRequired) {
  private_nh_.setParam("scan_topics", "");
  EXPECT_EQ(errorOfLoading(), "");
  private_nh_.setParam("cloud_topic", "");
  expectIn("scan_topics and cloud_topic are empty", errorOfLoading());
}

TEST_F(ProjectorParameters, AnglesMustBeReadable) {
  private_nh_.setParam("mirror_angles", "around the back");
  expectIn("around the back", errorOfLoading());
}

TEST(ProjectorProgram, EndsWithOneLineOnABadParameter) {
  const Outcome outcome = runNode("_max_tilt:=-1", 10);
  EXPECT_EQ(outcome.exit_code, 1);
  expectIn("FATAL", outcome.output);
  expectIn("scan_projector_node cannot run: max_tilt = -1: must be between 0 and 1.5 rad",
           outcome.output);
}

TEST(ProjectorProgram, SuggestsTheNearestNameOfAMisspelledParameter) {
  expectIn("Unknown parameter ~max_tillt; did you mean ~max_tilt?",
           runNode("_max_tillt:=0.4", 4).output);
}

TEST(ProjectorProgram, LogsTheReplacementOfAnOldParameter) {
  expectIn("~use_imu has no effect: ~attitude_source sets", runNode("_use_imu:=true", 4).output);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "projector_parameters_test");
  ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
