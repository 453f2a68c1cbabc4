// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/ros.h>

#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/ros/mapper/mapper_parameters.h"

namespace kestrel {
namespace {

/// The names of the sets in hector/parameters.yaml.
std::set<std::string> setNames() {
  const std::string prefix = "/sets/";
  std::vector<std::string> all;
  ros::param::getParamNames(all);
  std::set<std::string> names;
  for (const std::string& name : all) {
    if (name.compare(0, prefix.size(), prefix) != 0) continue;
    names.insert(name.substr(prefix.size(), name.find('/', prefix.size()) - prefix.size()));
  }
  return names;
}

MapperNodeConfig load(const std::string& set) {
  return loadParameters(ros::NodeHandle("/sets/" + set));
}

TEST(HectorParameters, EverySetStarts) {
  const std::set<std::string> names = setNames();
  EXPECT_GE(names.size(), 18U);
  for (const std::string& name : names) EXPECT_NO_THROW(load(name)) << name;
}

TEST(HectorParameters, NumbersAreLimited) {
  EXPECT_EQ(load("swapped_factors").slam.mapper.grid.miss_probability, 0.49);
  EXPECT_EQ(load("swapped_factors").slam.mapper.grid.hit_probability, 0.9);
  EXPECT_EQ(load("weak_factors").slam.mapper.grid.hit_probability, 0.51);
  EXPECT_EQ(load("fast_maps").map_pub_period, 0.1);
  EXPECT_EQ(load("unlimited_queue").scan_subscriber_queue_size, 1);
  EXPECT_EQ(load("far_laser").slam.projector.beams.max_range_m, 1000.0);
}

TEST(HectorParameters, AWindowWithoutTheLaserIsNotUsed) {
  const MapperNodeConfig defaults;
  EXPECT_EQ(load("second_height").slam.projector.slice_min_m, defaults.slam.projector.slice_min_m);
  EXPECT_EQ(load("second_height").slam.projector.slice_max_m, 2.1);
  EXPECT_EQ(load("below_the_laser").slam.projector.slice_max_m,
            defaults.slam.projector.slice_max_m);
}

TEST(HectorParameters, FramesThatAreTheSame) {
  EXPECT_FALSE(load("hovering_robot").pub_map_scanmatch_transform);
  EXPECT_FALSE(load("one_world_frame").usesOdometry());
  EXPECT_EQ(load("one_world_frame").map_frame, "odom");
  EXPECT_FALSE(load("handheld_rplidar").usesOdometry());
}

TEST(HectorParameters, TheFrameOfThePoseHasThePrefixOfTheBase) {
  EXPECT_EQ(load("two_robots").tf_map_scanmatch_transform_frame_name, "slam_1/scanmatcher_frame");
  EXPECT_EQ(load("fast_maps").tf_map_scanmatch_transform_frame_name, "scanmatcher_frame");
  EXPECT_EQ(load("tutorial").tf_map_scanmatch_transform_frame_name, "scanmatcher_frame");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "hector_parameters_test");
  ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
