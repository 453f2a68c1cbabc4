// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <string>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/recording/bag/bag_writer.h"
#include "kestrel_slam/recording/recording.h"
#include "mapper_client.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// Duration and rate of the replay.
constexpr double kDuration = 150.0;  // s
constexpr char kRate[] = "8";

/// Plays the recording of Freiburg building 79 with `rosbag play` through the live node, with
/// odometry. Compares the published poses with the reference relations, and tf with the poses.
TEST(ReplayFreiburg, Building79) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const TemporaryFolder folder;
  const std::string bag = folder.file("fr079.bag");
  writeBag(bag, *openRecording(data + "/freiburg/fr079.clf.bz2"), BagStamps::kRecorded);

  MapperClient client;
  Trajectory trajectory;
  const ros::Subscriber subscriber = client.nh.subscribe<geometry_msgs::PoseStamped>(
      "slam_out_pose", 1000, [&](const geometry_msgs::PoseStampedConstPtr& message) {
        trajectory.push_back({message->header.stamp.toSec(), poseOf(message->pose)});
      });
  const std::string command = "rosbag play --quiet --clock --delay=1 --rate=" + std::string(kRate) +
                              " --duration=" + std::to_string(kDuration) + " '" + bag +
                              "' >/dev/null 2>&1";
  FILE* player = popen(command.c_str(), "r");
  ASSERT_NE(player, nullptr);
  std::size_t before = 0;
  const auto silent = [&] {  // the replay has ended if no pose arrives for some time
    client.waitFor([&] { return trajectory.size() > before; }, 3.0);
    const bool none = trajectory.size() == before && before > 0;
    before = trajectory.size();
    return none;
  };
  EXPECT_TRUE(client.waitFor(silent));
  EXPECT_EQ(WEXITSTATUS(pclose(player)), 0);

  std::map<std::string, std::string> scans = client.report("Scans");
  EXPECT_GT(trajectory.size(), 600U);
  EXPECT_EQ(scans["received"], scans["used"]);
  EXPECT_EQ(scans["used"], std::to_string(trajectory.size()));
  EXPECT_EQ(client.diagnosis("Match", "state"), "ok");
  EXPECT_EQ(client.parents["odom"], std::set<std::string>{"map"});
  EXPECT_EQ(client.parents["base_link"], std::set<std::string>{"odom"});

  const RelationEvaluation errors =
      evaluateRelations(trajectory, readRelations(data + "/freiburg/fr079.relations"));
  EXPECT_GT(errors.all.translation_m.count, 100U);
  EXPECT_LT(errors.all.translation_m.mean, 0.035);
  EXPECT_LT(errors.all.rotation_deg.mean, 0.6);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "replay_freiburg_test");
  return RUN_ALL_TESTS();
}
