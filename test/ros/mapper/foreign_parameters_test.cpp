// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/foreign_parameters.h"

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/ros/mapper/mapper_parameters.h"

namespace kestrel {
namespace {

std::set<std::string> ownNames() {
  MapperNodeConfig config;
  std::set<std::string> names;
  for (const Parameter& parameter : parametersOf(config)) names.insert(parameter.name);
  return names;
}

/// A launch file of another package starts with its frames, and every parameter that has no effect
/// is said with its reason: none is unknown.
TEST(ForeignParameters, EverySetStartsAndNoNameIsUnknown) {
  const UnneededParameters foreign = foreignParameters();
  const std::set<std::string> own = ownNames();
  for (const std::string set : {"gmapping_turtlebot", "slam_toolbox_online_async"}) {
    const MapperNodeConfig config = loadParameters(ros::NodeHandle("/sets/" + set));
    EXPECT_EQ(config.odom_frame, "odom") << set;
    EXPECT_EQ(config.base_frame, "base_footprint") << set;
    std::vector<std::string> all;
    ros::param::getParamNames(all);
    const std::string prefix = "/sets/" + set + "/";
    for (const std::string& name : all) {
      if (name.compare(0, prefix.size(), prefix) != 0) continue;
      const std::string known = name.substr(prefix.size());
      EXPECT_TRUE(own.count(known) + foreign.count(known) > 0) << known;
    }
  }
}

/// A name that has a meaning here must not be called unneeded.
TEST(ForeignParameters, HideNoParameterOfThisNode) {
  for (const std::string& name : ownNames()) EXPECT_EQ(foreignParameters().count(name), 0U) << name;
}

TEST(ForeignParameters, NamesToSetInsteadExist) {
  const std::set<std::string> own = ownNames();
  const std::string begin = "here it is called ";
  for (const auto& [theirs, reason] : foreignParameters()) {
    if (reason.compare(0, begin.size(), begin) != 0) continue;
    const std::string name = reason.substr(begin.size());
    EXPECT_EQ(own.count(name.substr(0, name.find(' '))), 1U) << theirs << ": " << reason;
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "foreign_parameters_test");
  ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
