// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/ros.h>
#include <ros/topic.h>
#include <rosgraph_msgs/Log.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "kestrel_slam/map/map_io.h"
#include "patience.h"
#include "room.h"
#include "run_command.h"
#include "temporary_folder.h"

extern char** environ;

namespace kestrel {
namespace {

namespace fs = std::filesystem;

/// A running roslaunch. Its nodes end with it.
class Launch {
 public:
  explicit Launch(const std::string& file, const std::string& argument = "") {
    std::vector<std::string> words = {"roslaunch", "--disable-title", file};
    if (!argument.empty()) words.push_back(argument);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (posix_spawnp(&process_, "roslaunch", nullptr, nullptr, arguments.data(), environ) != 0)
      process_ = 0;
  }
  ~Launch() {
    if (process_ == 0) return;
    kill(process_, SIGINT);
    waitpid(process_, nullptr, 0);
  }
  Launch(const Launch&) = delete;
  Launch& operator=(const Launch&) = delete;

 private:
  pid_t process_ = 0;
};

/// What all nodes log, as one text.
class MigrationBase : public testing::Test {
 protected:
  MigrationBase() {
    const boost::function<void(const rosgraph_msgs::Log&)> keep =
        [this](const rosgraph_msgs::Log& message) {
          log_ += message.name + ": " + message.msg + "\n";
        };
    subscriber_ = nh_.subscribe<rosgraph_msgs::Log>("/rosout", 1000, keep);
  }

  bool says(const std::string& part) const { return log_.find(part) != std::string::npos; }
  bool waitFor(const std::string& part) {
    Patience patience;
    while (!says(part) && !patience.isOver()) {
      ros::spinOnce();
      ros::WallDuration(0.02).sleep();
    }
    return says(part);
  }

  ros::NodeHandle nh_;
  ros::Subscriber subscriber_;
  std::string log_;
};

class Migration : public MigrationBase, public testing::WithParamInterface<std::string> {};

/// The file of a real robot starts, and every line that has no effect is explained.
TEST_P(Migration, TheMapperStartsAndKnowsEveryName) {
  const std::string file = KESTREL_SOURCE_DIR "/test/ros/migration/launch/" + GetParam();
  const Launch launch(file);
  EXPECT_TRUE(waitFor("There is no scan on")) << log_;
  EXPECT_FALSE(says("Unknown parameter")) << log_;
  EXPECT_FALSE(says("cannot run")) << log_;
}

/// Its map is a pose graph of slam_toolbox, so it says what to change, and ends.
constexpr char kNeedsAMap[] = "slam_toolbox_localization.launch";

TEST(LocalizationTest, WithoutAMapTheNodeSaysWhatToChange) {
  const Outcome launch = runCommand("timeout 60 roslaunch --disable-title " KESTREL_SOURCE_DIR
                                    "/test/ros/migration/launch/" +
                                    std::string(kNeedsAMap) + " 2>&1");
  EXPECT_NE(launch.output.find("needs a map: set ~map_file or ~session"), std::string::npos)
      << launch.output;
  EXPECT_NE(launch.output.find("map_file_name has no effect: here it is called map_file"),
            std::string::npos)
      << launch.output;
  EXPECT_EQ(launch.output.find("Unknown parameter"), std::string::npos) << launch.output;
}

/// A picture of a map or a session, by the same argument.
TEST_F(MigrationBase, LocalizationLaunchTakesAMap) {
  const TemporaryFolder folder;
  writeMap(folder.file("office"), room::map().grid().snapshot());
  const Launch launch(KESTREL_SOURCE_DIR "/launch/localization.launch",
                      "map:=" + folder.file("office.yaml"));
  const auto map = ros::topic::waitForMessage<nav_msgs::OccupancyGrid>("map", ros::Duration(20.0));
  ASSERT_NE(map, nullptr) << log_;
  EXPECT_EQ(map->info.width, static_cast<unsigned>(room::map().grid().snapshot().width));
  EXPECT_TRUE(waitFor("There is no scan on /scan")) << log_;
}

std::vector<std::string> launchFiles() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(KESTREL_SOURCE_DIR "/test/ros/migration/launch"))
    if (entry.path().filename() != kNeedsAMap) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

INSTANTIATE_TEST_SUITE_P(Robots, Migration, testing::ValuesIn(launchFiles()),
                         [](const auto& file) { return fs::path(file.param).stem().string(); });

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "migration_test");
  const ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
