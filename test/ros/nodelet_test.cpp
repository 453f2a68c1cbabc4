// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nodelet/NodeletList.h>
#include <nodelet/NodeletLoad.h>
#include <nodelet/NodeletUnload.h>
#include <ros/network.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/conversions.h"
#include "projector_client.h"

namespace kestrel {
namespace {

constexpr char kManager[] = "manager";
constexpr char kProjector[] = "/flight/scan_projector";
constexpr char kMapper[] = "/flight/mapper";
constexpr double kLimit_m = 0.03;
constexpr double kLimit_rad = 0.01;
constexpr std::uint32_t kQueue = 100;

bool load(const std::string& name, const std::string& type) {
  nodelet::NodeletLoad service;
  service.request.name = name;
  service.request.type = "kestrel_slam/" + type;
  return ros::service::call(std::string(kManager) + "/load_nodelet", service) &&
         service.response.success;
}

bool unload(const std::string& name) {
  nodelet::NodeletUnload service;
  service.request.name = name;
  return ros::service::call(std::string(kManager) + "/unload_nodelet", service) &&
         service.response.success;
}

std::vector<std::string> loaded() {
  nodelet::NodeletList service;
  EXPECT_TRUE(ros::service::call(std::string(kManager) + "/list", service))
      << "the nodelet manager has stopped";
  std::sort(service.response.nodelets.begin(), service.response.nodelets.end());
  return service.response.nodelets;
}

/// The process id of a node, as reported by the node.
int pidOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = ros::names::resolve(node);
  if (!ros::master::execute("lookupNode", request, response, payload, false)) return -1;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(static_cast<std::string>(payload), host, port)) return -1;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller, answer;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, answer)) return -1;
  return static_cast<int>(answer[2]);
}

int threadsOf(int pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("Threads:", 0) == 0) return std::stoi(line.substr(line.find(':') + 1));
  }
  return -1;
}

/// A vehicle that hovers, tilts and turns, and both nodelets in one manager process.
class Nodelets : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_TRUE(ros::service::waitForService(std::string(kManager) + "/load_nodelet", 10000));
    client_ = new ProjectorClient("flight");
    ros::NodeHandle& nh = client_->nh;
    const boost::function<void(const geometry_msgs::PoseWithCovarianceStamped&)> on_pose =
        [](const geometry_msgs::PoseWithCovarianceStamped& message) { pose_ = message; };
    pose_subscriber_ =
        nh.subscribe<geometry_msgs::PoseWithCovarianceStamped>("poseupdate", kQueue, on_pose);
    const boost::function<void(const nav_msgs::OccupancyGrid&)> on_map =
        [](const nav_msgs::OccupancyGrid& message) { map_ = message; };
    map_subscriber_ = nh.subscribe<nav_msgs::OccupancyGrid>("map", kQueue, on_map);
  }
  static void TearDownTestSuite() {
    pose_subscriber_.shutdown();
    map_subscriber_.shutdown();
    delete client_;
  }

  static void loadBoth() {
    ASSERT_TRUE(load(kProjector, "ScanProjectorNodelet"));
    ASSERT_TRUE(load(kMapper, "MapperNodelet"));
    ASSERT_TRUE(client_->connect());
    ASSERT_TRUE(client_->waitFor([] {
      return client_->imu_publisher.getNumSubscribers() > 0 &&
             pose_subscriber_.getNumPublishers() > 0;
    }));
    client_->mount("laser", client_->base_T_laser);
    client_->mount("imu", Eigen::Isometry3d::Identity());
    waitForFirstPose();
  }

  static void unloadBoth() {
    EXPECT_TRUE(unload(kMapper));
    EXPECT_TRUE(unload(kProjector));
    EXPECT_TRUE(client_->waitFor([] {
      return client_->scan_publisher.getNumSubscribers() == 0 &&
             client_->imu_publisher.getNumSubscribers() == 0 &&
             pose_subscriber_.getNumPublishers() == 0;
    }));
  }

  static void publishScan() {
    client_->imu_time = std::max(client_->imu_time, client_->time - 0.05);
    client_->flyImu(client_->time + 0.05);
    client_->scan_publisher.publish(client_->nextScan());
  }

  /// The connection between the nodelets is not visible from outside. So scans are published until
  /// one gives a pose. This pose is the origin of the map.
  static void waitForFirstPose() {
    const ros::Time before = pose_.header.stamp;
    const auto came = [&] { return pose_.header.stamp != before; };
    for (int i = 0; i < 20 && !came(); ++i) {
      publishScan();
      client_->waitFor(came, 0.5);
    }
    ASSERT_TRUE(came()) << "no scan gives a pose";
    start_ = pose_.header.stamp;
  }

  /// Publishes scans to projector and mapper. Expects a correct pose for every scan.
  static void fly(int scans) {
    for (int i = 0; i < scans; ++i) {
      const ros::Time stamp(client_->time);
      publishScan();
      ASSERT_TRUE(client_->waitFor([&] { return pose_.header.stamp == stamp; }))
          << "no pose for scan " << i;
      const Pose2 pose = planarFromMessage(pose_.pose.pose);
      const double turn = client_->flight.yaw_rate * (stamp - start_).toSec();
      EXPECT_LT(pose.distance(), kLimit_m) << "scan " << i;
      EXPECT_LT(std::abs(normalizeAngle(pose.yaw - turn)), kLimit_rad) << "scan " << i;
    }
  }

  inline static ProjectorClient* client_ = nullptr;
  inline static ros::Subscriber pose_subscriber_, map_subscriber_;
  inline static geometry_msgs::PoseWithCovarianceStamped pose_;
  inline static nav_msgs::OccupancyGrid map_;
  inline static ros::Time start_;  ///< stamp of the first scan in the map
};

TEST_F(Nodelets, MapAFlight) {
  loadBoth();
  fly(80);
  EXPECT_EQ(loaded(), (std::vector<std::string>{kMapper, kProjector}));
  ASSERT_TRUE(client_->waitFor([] {
    return std::count(map_.data.begin(), map_.data.end(), 100) > 300;
  })) << "the map shows no walls";
  EXPECT_GT(std::count(map_.data.begin(), map_.data.end(), 0), 10000)
      << "free cells of 5 cm in a room of 8 m x 6 m";
  EXPECT_EQ(client_->parents["flight_footprint"], std::set<std::string>{"map"});
  EXPECT_EQ(client_->parents["flight_stabilized"], std::set<std::string>{"flight_footprint"});
  EXPECT_EQ(client_->parents["flight_base"], std::set<std::string>{"flight_stabilized"});
}

TEST_F(Nodelets, AnInvalidParameterDoesNotStopTheManager) {
  EXPECT_FALSE(load("/flight/bad_mapper", "MapperNodelet"));
  EXPECT_FALSE(load("/flight/bad_projector", "ScanProjectorNodelet"));
  EXPECT_EQ(loaded(), (std::vector<std::string>{kMapper, kProjector}));
}

TEST_F(Nodelets, ReportUnderTheirOwnNames) {
  NodeWatcher mapper("flight/mapper");
  EXPECT_EQ(mapper.diagnosis("Scans", "topic"), "/flight/planar_scan");
  EXPECT_EQ(mapper.diagnosis("Match", "state"), "ok");
  EXPECT_GE(std::stoi("0" + client_->diagnosis("Scans", "projected")), 81);
}

TEST_F(Nodelets, UnloadCleanlyAndLoadAgain) {
  const int pid = pidOf(kManager);
  unloadBoth();
  EXPECT_TRUE(loaded().empty());
  const int threads = threadsOf(pid);
  ASSERT_GT(threads, 0);
  loadBoth();
  EXPECT_GT(threadsOf(pid), threads);
  fly(20);
  publishScan();  // this scan is in a queue while the nodelets are unloaded
  unloadBoth();
  EXPECT_TRUE(loaded().empty());
  EXPECT_TRUE(client_->waitFor([&] { return threadsOf(pid) <= threads; }))
      << threadsOf(pid) << " threads remain, before there were " << threads;
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "nodelet_test");
  return RUN_ALL_TESTS();
}
