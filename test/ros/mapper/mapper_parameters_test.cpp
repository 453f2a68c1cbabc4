// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/mapper_parameters.h"

#include <gtest/gtest.h>
#include <ros/console.h>
#include <ros/ros.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace kestrel {
namespace {

/// Each test uses its own private namespace.
class MapperParameters : public testing::Test {
 protected:
  MapperParameters()
      : private_nh_(std::string("~") +
                    testing::UnitTest::GetInstance()->current_test_info()->name()) {}
  ~MapperParameters() override { private_nh_.deleteParam(""); }

  std::string errorOfLoading() const {
    try {
      loadParameters(private_nh_);
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
                              " " KESTREL_MAPPER_NODE " __name:=parameters " + argument + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  Outcome outcome{-1, ""};
  if (pipe == nullptr) return outcome;
  std::array<char, 1000> buffer{};
  while (fgets(buffer.data(), buffer.size(), pipe) != nullptr) outcome.output += buffer.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  return outcome;
}

TEST_F(MapperParameters, DefaultsNeedNoParameters) {
  const MapperNodeConfig config = loadParameters(private_nh_);
  EXPECT_EQ(config.base_frame, "base_link");
  EXPECT_EQ(config.map_frame, "map");
  EXPECT_EQ(config.scan_topic, "scan");
  EXPECT_FALSE(config.usesOdometry());
  EXPECT_EQ(config.scan_subscriber_queue_size, 5);
  EXPECT_EQ(config.map_pub_period, 2.0);
}

TEST_F(MapperParameters, AreReadWithTheirTypes) {
  private_nh_.setParam("map_resolution", 0.025);
  private_nh_.setParam("laser_max_dist", 12);  // an integer for a real parameter
  private_nh_.setParam("scan_subscriber_queue_size", 7.0);
  private_nh_.setParam("pub_odometry", true);
  private_nh_.setParam("odom_frame", "/odom");  // as tf1 wrote it
  const MapperNodeConfig config = loadParameters(private_nh_);
  EXPECT_EQ(config.slam.mapper.grid.resolution_m, 0.025);
  EXPECT_EQ(config.slam.projector.beams.max_range_m, 12.0);
  EXPECT_EQ(config.scan_subscriber_queue_size, 7);
  EXPECT_TRUE(config.pub_odometry);
  EXPECT_EQ(config.odom_frame, "odom");
  EXPECT_TRUE(config.usesOdometry());
}

TEST_F(MapperParameters, AllOfHectorMappingAreAccepted) {
  const char* names[] = {"map_size",
                         "map_start_x",
                         "map_start_y",
                         "map_multi_res_levels",
                         "output_timing",
                         "use_tf_scan_transformation",
                         "use_tf_pose_start_estimate",
                         "map_with_known_poses",
                         "pub_drawings",
                         "pub_debug_output"};
  for (const char* name : names) private_nh_.setParam(name, 1);
  private_nh_.setParam("laser_z_min_value", -1.0);
  private_nh_.setParam("laser_z_max_value", 1.0);
  EXPECT_EQ(errorOfLoading(), "");
}

TEST_F(MapperParameters, InputChoosesTheTopic) {
  private_nh_.setParam("scan_topic", "front");
  private_nh_.setParam("planar_scan_topic", "slice");
  EXPECT_EQ(loadParameters(private_nh_).inputTopic(), "front");
  private_nh_.setParam("input", "planar_scan");
  EXPECT_EQ(loadParameters(private_nh_).inputTopic(), "slice");
  private_nh_.setParam("planar_scan_topic", "");
  EXPECT_NE(errorOfLoading().find("planar_scan_topic"), std::string::npos);
  private_nh_.setParam("input", "cloud");
  EXPECT_NE(errorOfLoading().find("input = cloud"), std::string::npos);
}

TEST_F(MapperParameters, OutOfRangeNamesValueAndRange) {
  private_nh_.setParam("map_pub_period", -2.0);
  const std::string error = errorOfLoading();
  EXPECT_NE(error.find("map_pub_period = -2"), std::string::npos) << error;
  EXPECT_NE(error.find("between 0.1 and 3600 s"), std::string::npos) << error;
}

TEST_F(MapperParameters, WrongTypesAreRefused) {
  private_nh_.setParam("map_resolution", "fine");
  EXPECT_NE(errorOfLoading().find("map_resolution = fine"), std::string::npos);
  private_nh_.setParam("map_resolution", std::vector<double>{0.1, 0.2});
  EXPECT_NE(errorOfLoading().find("map_resolution: must be a single value"), std::string::npos);
}

TEST_F(MapperParameters, FramesMustDiffer) {
  private_nh_.setParam("map_frame", "base_link");
  EXPECT_NE(errorOfLoading().find("map_frame = base_link"), std::string::npos);
  private_nh_.setParam("map_frame", "world");
  private_nh_.setParam("odom_frame", "world");
  EXPECT_EQ(errorOfLoading(), "") << "as with hector_mapping: no odometry";
  EXPECT_FALSE(loadParameters(private_nh_).usesOdometry());
  private_nh_.setParam("odom_frame", "base_link");  // means that there is no odometry
  EXPECT_EQ(errorOfLoading(), "");
}

TEST_F(MapperParameters, TheInstalledFileContainsTheDefaults) {
  ASSERT_TRUE(ros::param::has("/shipped/map_resolution"));
  const MapperNodeConfig config = loadParameters(ros::NodeHandle("/shipped"));
  EXPECT_EQ(config.slam.mapper.grid.resolution_m, OccupancyGridConfig().resolution_m);
  EXPECT_EQ(config.slam.projector.ignored_angles, "");
}

TEST(MapperProgram, EndsWithOneLineOnABadParameter) {
  const Outcome outcome = runNode("_map_resolution:=-1", 10);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.output.find("FATAL"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("map_resolution = -1: must be between 0.005 and 1 m"),
            std::string::npos)
      << outcome.output;
  ros::param::del("/parameters");
}

TEST(MapperProgram, SuggestsTheNearestNameOfAMisspelledParameter) {
  const Outcome outcome = runNode("_map_resolutoin:=0.1", 4);
  EXPECT_NE(outcome.output.find("Unknown parameter ~map_resolutoin; did you mean ~map_resolution?"),
            std::string::npos)
      << outcome.output;
  ros::param::del("/parameters");
}

TEST(MapperProgram, LogsOnceWhyParametersOfTheProjectorAreNotNeeded) {
  const Outcome outcome = runNode("_gravity_time:=4 _gravity_gate:=0.1", 4);
  EXPECT_NE(outcome.output.find("~gravity_gate, ~gravity_time have no effect: only "
                                "scan_projector_node uses the attitude"),
            std::string::npos)
      << outcome.output;
  ros::param::del("/parameters");
}

TEST(MapperProgram, LogsWhyAParameterIsNotNeeded) {
  const Outcome outcome = runNode("_map_size:=2048", 4);
  EXPECT_NE(outcome.output.find("~map_size has no effect: the map has no fixed size"),
            std::string::npos)
      << outcome.output;
  ros::param::del("/parameters");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "mapper_parameters_test");
  ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
