// SPDX-License-Identifier: BSD-3-Clause
// Saves, kills and continues a real mapper node, which the test starts itself.
#include <gtest/gtest.h>
#include <signal.h>
#include <std_srvs/Trigger.h>

#include <filesystem>
#include <thread>

#include "graph/loop_world.h"
#include "kestrel_slam/LoadSession.h"
#include "kestrel_slam/SaveSession.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/session/session_file.h"
#include "mapper_client.h"
#include "ros/mapper/mapper_process.h"
#include "ros/mapper/ring_scan.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

using Node = MapperProcess;

class LiveSession : public ::testing::Test {
 protected:
  void SetUp() override { client_.emplace(); }

  /// Flies along `path`; returns the pose at the end.
  std::optional<Pose2> fly(const std::vector<Pose2>& path) {
    std::optional<Pose2> pose;
    for (const Pose2& truth : path) {
      stamp_ += ros::Duration(0.1);
      pose = client_->match(messageAt(truth, stamp_), 10.0);
      if (!pose) break;
    }
    return pose;
  }

  static kestrel_slam::SaveSession::Response save(const std::string& path) {
    kestrel_slam::SaveSession service;
    service.request.path = path;
    EXPECT_TRUE(ros::service::waitForService("save_session", ros::Duration(20.0)));
    EXPECT_TRUE(ros::service::call("save_session", service));
    return service.response;
  }

  static kestrel_slam::LoadSession::Response load(const std::string& path,
                                                  const std::string& start = "last") {
    kestrel_slam::LoadSession service;
    service.request.path = path;
    service.request.start = start;
    EXPECT_TRUE(ros::service::call("load_session", service));
    return service.response;
  }

  std::string inFolder() const { return "_session_folder:=" + folder_.file(""); }

  TemporaryFolder folder_;
  std::optional<MapperClient> client_;
  ros::Time stamp_ = ros::Time::now();
};

std::vector<Pose2> part(const std::vector<Pose2>& path, double from, double to) {
  const auto at = [&](double share) {
    return path.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(path.size()));
  };
  return {at(from), at(to)};
}

TEST_F(LiveSession, IsContinuedAfterTheNodeWasKilled) {
  const std::vector<Pose2> path = loop_world::laps(1.0);
  const std::vector<Pose2> day1 = part(path, 0.0, 0.4), day2 = part(path, 0.0, 0.4);
  {
    Node node({inFolder()});
    ASSERT_TRUE(client_->connect());
    ASSERT_TRUE(fly(day1));
    const auto saved = save("office");
    ASSERT_TRUE(saved.success) << saved.message;
    EXPECT_EQ(saved.message.substr(0, 6), "saved ");
    node.end(SIGKILL);
  }
  const std::string file = folder_.file("office.session");
  ASSERT_TRUE(fs::exists(file));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.file("")), fs::directory_iterator()), 1);
  const Session first = loadSession(file);
  EXPECT_GT(first.keyframes.size(), 30U);
  ASSERT_TRUE(first.end);
  client_.emplace();
  Node node({inFolder(), "_session:=" + file});
  ASSERT_TRUE(client_->connect());
  EXPECT_TRUE(client_->waitFor([&] { return client_->map.info.width > 100; }))
      << "the old map is shown";
  // Back along the old path, from where the session ended.
  std::vector<Pose2> back(day2.rbegin(), day2.rend());
  const std::optional<Pose2> pose = fly(back);
  ASSERT_TRUE(pose);
  const Pose2 truth = path.front().between(back.back());
  EXPECT_LT(truth.between(*pose).distance(), 0.2);
  // The graph's thread joins both flights in its own time.
  Session second;
  const auto joined_and_known = [&] {
    EXPECT_TRUE(save("office.session").success);
    second = loadSession(file);
    return connectedParts(graphOf(second)).back() == 0U &&
           second.keyframes.size() <= first.keyframes.size() * 11 / 10;
  };
  EXPECT_TRUE(client_->waitFor(joined_and_known))
      << second.keyframes.size() << " keyframes, before " << first.keyframes.size()
      << ", the last one in part " << connectedParts(graphOf(second)).back();
}

TEST_F(LiveSession, LoadsWhileScansArriveAndTwoLoadsAtOnce) {
  const std::vector<Pose2> path = part(loop_world::laps(1.0), 0.0, 0.2);
  Node node({inFolder()});
  ASSERT_TRUE(client_->connect());
  ASSERT_TRUE(fly(path));
  ASSERT_TRUE(save("a").success);
  std::vector<kestrel_slam::LoadSession::Response> answers(2);
  std::vector<std::thread> loaders;
  for (auto& answer : answers) loaders.emplace_back([&] { answer = load("a"); });
  ros::WallRate rate(40.0);
  const std::size_t before = client_->poses_received;
  for (int i = 0; i < 60; ++i, rate.sleep()) {
    stamp_ += ros::Duration(0.025);
    client_->publish(messageAt(path.back(), stamp_));
    ros::spinOnce();
  }
  for (std::thread& loader : loaders) loader.join();
  for (const auto& answer : answers) EXPECT_TRUE(answer.success) << answer.message;
  EXPECT_TRUE(client_->waitFor([&] { return client_->poses_received > before + 20; }));
  ASSERT_TRUE(fly({path.back()})) << "it still maps";
}

TEST_F(LiveSession, RefusesWhatIsNoSession) {
  Node node({inFolder(), "_autosave_minutes:=0.02"});
  ASSERT_TRUE(client_->connect());
  ASSERT_TRUE(fly(part(loop_world::laps(1.0), 0.0, 0.1)));
  ASSERT_TRUE(save("a").success);
  folder_.write("map.pgm", "P5 2 2 255\n1234");
  const std::string bytes = readFile(folder_.file("a.session"));
  folder_.write("cut.session", bytes.substr(0, bytes.size() / 2));
  fs::create_directory(folder_.file("empty"));
  const auto refusal = [&](const std::string& path) {
    const auto answer = load(path);
    EXPECT_FALSE(answer.success) << path;
    return answer.message;
  };
  EXPECT_NE(refusal("map.pgm").find("not a session of kestrel_slam"), std::string::npos);
  EXPECT_NE(refusal("cut.session").find("damaged"), std::string::npos);
  EXPECT_NE(refusal("empty").find("folder"), std::string::npos);
  EXPECT_NE(refusal("missing").find("missing"), std::string::npos);
  EXPECT_NE(refusal("../a.session").find("session_folder"), std::string::npos);
  EXPECT_NE(refusal("/etc/passwd").find("session_folder"), std::string::npos);
  EXPECT_NE(refusal("").find("no file name"), std::string::npos);
  EXPECT_NE(load("a", "somewhere").message.find("last, pose or unknown"), std::string::npos);
  EXPECT_FALSE(save("map.pgm").success);
  EXPECT_EQ(readFile(folder_.file("map.pgm")).substr(0, 2), "P5") << "it was not replaced";
  EXPECT_FALSE(save("../b").success);
  ASSERT_TRUE(fly({loop_world::laps(1.0)[20]})) << "it still maps";
  EXPECT_TRUE(client_->waitFor([&] { return fs::exists(folder_.file("autosave.session")); }));
  EXPECT_NO_THROW(loadSession(folder_.file("autosave.session")));
}

/// A new map after a crash does not cost the old one.
TEST_F(LiveSession, TheAutosaveOfAnEarlierRunIsKept) {
  Session earlier;
  earlier.written_by = "kestrel_slam test";
  saveSession(folder_.file("autosave.session"), earlier);
  Node node({inFolder(), "_autosave_minutes:=0.02"});
  ASSERT_TRUE(client_->connect());
  ASSERT_TRUE(fly(part(loop_world::laps(1.0), 0.0, 0.05)));
  const std::string file = folder_.file("autosave.session"),
                    old = folder_.file("autosave.old.session");
  EXPECT_TRUE(client_->waitFor([&] { return fs::exists(old) && isSessionFile(file); }));
  EXPECT_TRUE(loadSession(old).keyframes.empty());
}

TEST_F(LiveSession, ASessionThatCannotBeLoadedEndsTheNodeAtItsStart) {
  Node node({inFolder(), "_session:=" + folder_.file("missing.session")});
  EXPECT_NE(node.wait(), 0);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_session_test");
  const ros::NodeHandle started;  // the fixtures use the time of ROS
  return RUN_ALL_TESTS();
}
