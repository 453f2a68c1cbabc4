// SPDX-License-Identifier: BSD-3-Clause
// What a node logs if no data arrive: one clear line within 3 s, and then rarely.

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/String.h>

#include <sstream>
#include <string>
#include <vector>

#include "run_command.h"

namespace kestrel {
namespace {

constexpr std::size_t kMaxLine = 200;

/// The warnings of a node that runs for some seconds, without time stamps and colors.
std::vector<std::string> warningsOf(const std::string& program, const std::string& arguments) {
  const Outcome outcome =
      runCommand("timeout -s INT 5 " + program + " __name:=silent " + arguments);
  std::vector<std::string> warnings;
  std::istringstream lines(outcome.output);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t start = line.find("]: ");
    if (line.find("WARN") == std::string::npos || start == std::string::npos) continue;
    warnings.push_back(line.substr(start + 3, line.find('\033', start) - start - 3));
  }
  ros::param::del("/silent");
  return warnings;
}

/// The only warning of the node about silence.
std::string warningOf(const std::string& program, const std::string& arguments = "") {
  std::string found;
  int count = 0;
  for (const std::string& warning : warningsOf(program, arguments)) {
    if (warning.find("There is no") == std::string::npos) continue;
    ++count;
    found = warning;
    EXPECT_LT(warning.size(), kMaxLine) << warning;
  }
  EXPECT_EQ(count, 1) << found;
  return found;
}

const std::string kMapper = KESTREL_MAPPER_NODE;
const std::string kProjector = KESTREL_SCAN_PROJECTOR_NODE;

class SilentStart : public testing::Test {
 protected:
  template <typename Message>
  void advertise(const std::string& topic) {
    publishers_.push_back(nh_.advertise<Message>(topic, 1));
  }
  ros::NodeHandle nh_;
  std::vector<ros::Publisher> publishers_;
};

#define EXPECT_CONTAINS(text, part) \
  EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

TEST_F(SilentStart, NobodyPublishes) {
  EXPECT_CONTAINS(warningOf(kMapper), "no scan on /scan");
  EXPECT_CONTAINS(warningOf(kMapper), "check that the driver runs");
}

TEST_F(SilentStart, AnotherTopicHasScans) {
  advertise<sensor_msgs::LaserScan>("/front/scan");
  const std::string warning = warningOf(kMapper);
  EXPECT_CONTAINS(warning, "/front/scan");
  EXPECT_CONTAINS(warning, "~scan_topic");
}

TEST_F(SilentStart, TheTopicHasAnotherType) {
  advertise<sensor_msgs::PointCloud2>("/scan");
  const std::string warning = warningOf(kMapper);
  EXPECT_CONTAINS(warning, "has the type sensor_msgs/PointCloud2, not sensor_msgs/LaserScan");
}

TEST_F(SilentStart, APublisherWithoutMessages) {
  advertise<sensor_msgs::LaserScan>("/scan");
  EXPECT_CONTAINS(warningOf(kMapper), "1 publisher(s), but no message");
}

TEST_F(SilentStart, SimulatedTimeWithoutAClock) {
  ros::param::set("/use_sim_time", true);
  const std::string mapper = warningOf(kMapper);
  const std::string projector = warningOf(kProjector, "_attitude_source:=none");
  ros::param::del("/use_sim_time");
  EXPECT_CONTAINS(mapper, "nobody publishes /clock");
  EXPECT_CONTAINS(projector, "nobody publishes /clock");
}

TEST_F(SilentStart, TheProjectorNamesTheImu) {
  advertise<std_msgs::String>("/imu/data");
  bool is_named = false;
  for (const std::string& warning : warningsOf(kProjector, "")) {
    EXPECT_LT(warning.size(), kMaxLine) << warning;
    is_named |=
        warning.find("has the type std_msgs/String, not sensor_msgs/Imu") != std::string::npos;
  }
  EXPECT_TRUE(is_named);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "silent_start_test");
  return RUN_ALL_TESTS();
}
