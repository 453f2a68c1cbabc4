// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nav_msgs/GetMap.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr char kRecording[] = "mav/handheld_urg04lx.bag";
constexpr char kRate[] = "3";

std::string recordingPath() {
  const char* data = std::getenv("KESTREL_DATA");
  const std::string folder = data != nullptr ? data : KESTREL_SOURCE_DIR "/../shared/data";
  return folder + "/" + kRecording;
}

/// Plays the recording of a handheld laser with `rosbag play --clock` through the node. Laser only.
TEST(Replay, HandheldLaser) {
  if (!std::filesystem::exists(recordingPath())) {
    GTEST_SKIP() << recordingPath() << " is absent; set KESTREL_DATA to the folder of the data";
  }
  MapperClient client;
  const std::string command = std::string("rosbag play --quiet --clock --delay=1 --rate=") + kRate +
                              " '" + recordingPath() + "' >/dev/null 2>&1";
  FILE* player = popen(command.c_str(), "r");
  ASSERT_NE(player, nullptr);
  const auto ended = [&] { return client.poses_received >= 360; };
  EXPECT_TRUE(client.waitFor(ended)) << client.poses_received << " of 360 poses";
  EXPECT_EQ(WEXITSTATUS(pclose(player)), 0);

  EXPECT_EQ(client.diagnosis("Scans", "received"), "360");
  EXPECT_EQ(client.diagnosis("Scans", "used"), "360");
  EXPECT_EQ(client.diagnosis("Match", "state"), "ok");
  EXPECT_GT(std::stod(client.diagnosis("Match", "score")), 0.5);
  EXPECT_EQ(client.parents["laser"], std::set<std::string>{"map"});

  nav_msgs::GetMap service;
  ASSERT_TRUE(ros::service::call("dynamic_map", service));
  const auto& cells = service.response.map.data;
  EXPECT_GT(std::count(cells.begin(), cells.end(), 100), 500);
  EXPECT_GT(std::count(cells.begin(), cells.end(), 0), 5000);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "replay_test");
  return RUN_ALL_TESTS();
}
