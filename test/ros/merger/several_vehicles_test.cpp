// SPDX-License-Identifier: BSD-3-Clause
// Three vehicles in one building and one master, with several_vehicles.launch.
#include <XmlRpcClient.h>
#include <gtest/gtest.h>
#include <ros/network.h>
#include <signal.h>
#include <std_msgs/String.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "kestrel_slam/JoinVehicle.h"
#include "kestrel_slam/SaveSession.h"
#include "kestrel_slam/SeparateVehicles.h"
#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/session/session_file.h"
#include "mapper_client.h"
#include "merging/building.h"
#include "ros/mapper/ring_scan.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kLong = 90.0;  // s: only a failing test waits so long

/// roslaunch, with all its nodes.
class Launch {
 public:
  explicit Launch(const std::string& sessions) {
    pid_ = fork();
    if (pid_ != 0) return;
    const std::string folder = "sessions:=" + sessions;
    execlp("roslaunch", "roslaunch", "kestrel_slam", "several_vehicles.launch", folder.c_str(),
           "autosave_minutes:=0.02", "period:=1", "in_world:=true", nullptr);
    _exit(127);
  }
  ~Launch() {
    kill(pid_, SIGINT);
    waitpid(pid_, nullptr, 0);
  }
  Launch(const Launch&) = delete;
  Launch& operator=(const Launch&) = delete;

 private:
  pid_t pid_;
};

/// Process id of a node; 0 if it does not answer.
int processOf(const std::string& node) {
  XmlRpc::XmlRpcValue question, answer, payload;
  question[0] = ros::this_node::getName();
  question[1] = node;
  if (!ros::master::execute("lookupNode", question, answer, payload, false)) return 0;
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(payload, host, port);
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port));
  XmlRpc::XmlRpcValue request, result;
  request[0] = ros::this_node::getName();
  if (!client.execute("getPid", request, result) || result.size() < 3) return 0;
  return result[2];
}

/// One vehicle that flies on a given way.
struct Vehicle {
  Vehicle(const std::string& vehicle, std::vector<Pose2> poses)
      : name(vehicle), way(std::move(poses)), client(std::make_unique<MapperClient>(vehicle)) {}

  std::string name;
  std::vector<Pose2> way;
  std::unique_ptr<MapperClient> client;
  std::size_t flown = 0;
  Trajectory truth;
  ros::Time last;
};

class SeveralVehicles : public testing::Test {
 protected:
  SeveralVehicles() : launch_(folder_.file("")) {
    vehicles_.emplace_back("uav0", building::tour(0, 2));
    vehicles_.emplace_back("uav1", building::tour(2, 0));
    vehicles_.emplace_back("uav2", building::tour(1, 2));
    status_subscriber_ = nh_.subscribe<std_msgs::String>(
        "merge_status", 1, [this](const std_msgs::String::ConstPtr& message) {
          status_ = nlohmann::json::parse(message->data);
        });
    map_subscriber_ = nh_.subscribe<nav_msgs::OccupancyGrid>(
        "map", 1, [this](const nav_msgs::OccupancyGrid::ConstPtr& message) { map_ = *message; });
    for (const char* name : {"uav0", "uav0_before", "uav1", "uav2"}) {
      path_subscribers_.push_back(nh_.subscribe<nav_msgs::Path>(
          std::string(name) + "/trajectory_in_world", 1,
          [this, name](const nav_msgs::Path::ConstPtr& message) { paths_[name] = *message; }));
    }
    // Not slam_out_pose: while the vehicle is lost, that is a prediction.
    in_world_subscriber_ = nh_.subscribe<geometry_msgs::PoseWithCovarianceStamped>(
        "uav2/in_world/poseupdate", 10,
        [this](const geometry_msgs::PoseWithCovarianceStamped::ConstPtr& message) {
          in_world_ = *message;
        });
    pose_subscriber_ = nh_.subscribe<geometry_msgs::PoseStamped>(
        "uav2/pose_in_world", 1,
        [this](const geometry_msgs::PoseStamped::ConstPtr& message) { pose_ = *message; });
  }

  bool waitFor(const std::function<bool()>& condition) {
    return vehicles_[0].client->waitFor(condition, kLong);
  }

  /// Each scan is sent when the vehicle's mapper has matched the one before. The node that finds
  /// uav2 in the map of all may have missed some.
  bool fly(Vehicle& vehicle, std::size_t until) {
    static const building::Walls walls = building::walls();
    for (; vehicle.flown < std::min(until, vehicle.way.size()); ++vehicle.flown) {
      stamp_ += ros::Duration(0.1);
      const Pose2& pose = vehicle.way[vehicle.flown];
      sensor_msgs::LaserScan scan = messageAt(pose, stamp_, walls);
      scan.header.frame_id = vehicle.name + "/base_link";
      vehicle.truth.push_back({stamp_.toSec(), pose});
      vehicle.last = stamp_;
      if (!vehicle.client->match(scan, kLong)) return false;
    }
    return true;
  }

  bool connect() {
    const bool hears = waitFor([this] {
      return std::all_of(vehicles_.begin(), vehicles_.end(),
                         [](Vehicle& vehicle) { return vehicle.client->hearsPoses(); });
    });
    // A mapper subscribes to the scans after it has announced its poses. The other subscriber finds
    // the vehicle in the map of all.
    constexpr std::size_t kNodes = 2;
    return hears && std::all_of(vehicles_.begin(), vehicles_.end(),
                                [](Vehicle& vehicle) { return vehicle.client->connect(kNodes); });
  }

  /// Saves as autosave does, so that nothing is lost when the mapper is killed.
  void save(const std::string& name) {
    kestrel_slam::SaveSession service;
    service.request.path = "autosave.session";
    ASSERT_TRUE(ros::service::call("/" + name + "/save_session", service));
    ASSERT_TRUE(service.response.success) << service.response.message;
  }

  /// Kills a node; roslaunch starts it again.
  void killNode(const std::string& node) {
    const int process = processOf(node);
    ASSERT_GT(process, 0) << node;
    kill(process, SIGKILL);
    ASSERT_TRUE(waitFor([&] {
      const int next = processOf(node);
      return next > 0 && next != process;
    })) << node;
  }

  bool allAreJoined(std::size_t count) const {
    if (status_.is_null() || status_["vehicles"].size() != count) return false;
    for (const auto& vehicle : status_["vehicles"])
      if (vehicle["group"] != status_["vehicles"][0]["group"]) return false;
    return true;
  }

  std::string stateOf(const std::string& a, const std::string& b) const {
    if (status_.is_null()) return "";
    for (const auto& pair : status_["pairs"])
      if ((pair["a"] == a && pair["b"] == b) || (pair["a"] == b && pair["b"] == a))
        return pair["state"];
    return "";
  }

  /// Whether the last keyframe of a vehicle is in the merged map.
  bool isComplete(const Vehicle& vehicle) {
    constexpr double kKeyframe = 2.0;  // s: a keyframe comes at least as often
    const auto& poses = paths_[vehicle.name].poses;
    return !poses.empty() && (vehicle.last - poses.back().header.stamp).toSec() < kKeyframe;
  }

  Trajectory inWorld() {
    Trajectory all;
    for (const auto& [name, path] : paths_) {
      for (const geometry_msgs::PoseStamped& pose : path.poses)
        all.push_back({pose.header.stamp.toSec(), poseOf(pose.pose)});
    }
    std::sort(all.begin(), all.end(),
              [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
    return all;
  }

  Trajectory truth() const {
    Trajectory all;
    for (const Vehicle& vehicle : vehicles_)
      all.insert(all.end(), vehicle.truth.begin(), vehicle.truth.end());
    std::sort(all.begin(), all.end(),
              [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
    return all;
  }

  /// ATE of all trajectories in world, m.
  double error() { return evaluateReference(inWorld(), truth()).ate_statistics.translation_m.rmse; }

  void checkServices();
  void checkInWorld();

  TemporaryFolder folder_;
  Launch launch_;
  ros::NodeHandle nh_;
  std::vector<Vehicle> vehicles_;
  ros::Subscriber status_subscriber_, map_subscriber_, pose_subscriber_, in_world_subscriber_;
  std::vector<ros::Subscriber> path_subscribers_;
  nlohmann::json status_;
  nav_msgs::OccupancyGrid map_;
  geometry_msgs::PoseStamped pose_;
  geometry_msgs::PoseWithCovarianceStamped in_world_;
  std::map<std::string, nav_msgs::Path> paths_;
  ros::Time stamp_ = ros::Time::now();
};

void SeveralVehicles::checkServices() {
  kestrel_slam::JoinVehicle join;
  join.request.vehicle = "nobody";
  join.request.world_T_map.orientation.w = 1.0;
  ASSERT_TRUE(ros::service::call("join", join));
  EXPECT_FALSE(join.response.success) << "there is no such vehicle";
  join.request.vehicle = "uav2";
  join.request.world_T_map.position.x = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(ros::service::call("join", join));
  EXPECT_FALSE(join.response.success) << "no pose";
  kestrel_slam::SeparateVehicles separate;
  separate.request.first = separate.request.second = "uav0";
  ASSERT_TRUE(ros::service::call("separate", separate));
  EXPECT_FALSE(separate.response.success) << "one vehicle";
  separate.request.second = "uav2";
  ASSERT_TRUE(ros::service::call("separate", separate));
  EXPECT_TRUE(separate.response.success) << separate.response.message;
  EXPECT_TRUE(waitFor([this] { return stateOf("uav0", "uav2") == "separated"; })) << status_;
  killNode("/map_merger");
  status_ = nullptr;
  EXPECT_TRUE(waitFor([this] { return !status_.is_null(); }));
  EXPECT_EQ(stateOf("uav0", "uav2"), "separated") << "the merger was restarted";
  ASSERT_TRUE(ros::service::waitForService("join", ros::Duration(kLong)));
  const Pose2 start = vehicles_[0].way[0].between(vehicles_[2].way[0]);
  join.request.world_T_map.position.x = start.x + 0.5;
  join.request.world_T_map.position.y = start.y;
  ASSERT_TRUE(ros::service::call("join", join));
  EXPECT_TRUE(join.response.success) << join.response.message;
  EXPECT_TRUE(waitFor([this] { return stateOf("uav0", "uav2") == "joined"; })) << status_;
  kestrel_slam::SaveSession save;
  save.request.path = "../outside";
  ASSERT_TRUE(ros::service::call("save_session", save));
  EXPECT_FALSE(save.response.success);
  save.request.path = "fleet";
  ASSERT_TRUE(ros::service::call("save_session", save));
  ASSERT_TRUE(save.response.success) << save.response.message;
  const Session session = loadSession(folder_.file("merged/fleet.session"));
  EXPECT_EQ(session.keyframes.size(), inWorld().size());
}

/// A vehicle flies back the way it came, and knows where it is in the map of all.
void SeveralVehicles::checkInWorld() {
  constexpr double kSoon = 0.5;  // s
  Vehicle& vehicle = vehicles_[2];
  const std::vector<Pose2> way = vehicle.way;
  vehicle.way.insert(vehicle.way.end(), way.rbegin(), way.rend());
  std::size_t found = 0;
  while (vehicle.flown < vehicle.way.size() && found < 20) {
    ASSERT_TRUE(fly(vehicle, vehicle.flown + 1));
    if (!vehicle.client->waitFor([this] { return in_world_.header.stamp == stamp_; }, kSoon))
      continue;
    ++found;
    const Pose2 truth = vehicles_[0].way[0].between(vehicle.way[vehicle.flown - 1]);
    const Pose2 pose = poseOf(in_world_.pose.pose);
    EXPECT_LT(truth.between(pose).distance(), 0.15)
        << "scan " << vehicle.flown << ": " << pose.x << ' ' << pose.y << ' ' << pose.yaw
        << " instead of " << truth.x << ' ' << truth.y << ' ' << truth.yaw;
  }
  EXPECT_EQ(found, 20U);
  EXPECT_EQ(in_world_.header.frame_id, "world");
}

TEST_F(SeveralVehicles, OneMapThoughAVehicleAndTheMergerAreRestarted) {
  ASSERT_TRUE(connect());
  for (Vehicle& vehicle : vehicles_)
    ASSERT_TRUE(fly(vehicle, vehicle.way.size() / 2)) << vehicle.name;
  ASSERT_TRUE(waitFor([this] { return !status_.is_null(); }));
  // `world` is the map of the first vehicle, and stays where it is.
  save("uav0");
  killNode("/uav0/mapper");
  killNode("/map_merger");
  vehicles_[0].client = std::make_unique<MapperClient>("uav0");
  ASSERT_TRUE(connect());
  for (Vehicle& vehicle : vehicles_) ASSERT_TRUE(fly(vehicle, vehicle.way.size())) << vehicle.name;
  status_ = nullptr;
  ASSERT_TRUE(waitFor([this] {
    return allAreJoined(4) && std::all_of(vehicles_.begin(), vehicles_.end(),
                                          [this](Vehicle& v) { return isComplete(v); });
  })) << status_;
  EXPECT_EQ(map_.header.frame_id, "world");
  EXPECT_GT(map_.data.size(), 10'000U);
  EXPECT_TRUE(waitFor([this] { return pose_.header.frame_id == "world"; }));
  for (const char* name : {"uav0", "uav1", "uav2"}) {
    const std::string frame = std::string(name) + "/map";
    EXPECT_TRUE(waitFor([&] { return vehicles_[0].client->parents[frame].count("world") > 0; }));
    EXPECT_EQ(vehicles_[0].client->parents[frame].size(), 1U);
  }
  RecordProperty("ate_mm", static_cast<int>(1e3 * error()));
  EXPECT_LT(error(), 0.05);
  checkServices();
  checkInWorld();
  EXPECT_LT(error(), 0.05) << "after the vehicle was separated and joined again";
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "several_vehicles_test");
  ros::start();
  return RUN_ALL_TESTS();
}
