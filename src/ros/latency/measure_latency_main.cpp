// SPDX-License-Identifier: BSD-3-Clause
#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <cstdio>
#include <exception>
#include <map>
#include <stdexcept>
#include <string>

#include "kestrel_slam/ros/latency/latency_record.h"
#include "kestrel_slam/ros/latency/live_player.h"

namespace {

using namespace kestrel;

constexpr char kUsage[] =
    "measure_latency BAG: plays laser, IMU and range finder of a bag in real time to the\n"
    "running nodes (roslaunch kestrel_slam mav.launch). Measures the latency from every scan\n"
    "to its pose on `poseupdate`, and from every IMU message to its state on `odom/filtered`.\n"
    "Exit code: 0, or 1 if no pose arrived.\n"
    "measure_latency --echo: a node that only answers every IMU message on `odom/echo`. Run it\n"
    "together with the other nodes to measure the shortest possible latency of a node.\n";
constexpr std::uint32_t kQueue = 1000;
constexpr double kConnectWithin = 20.0;  // s
constexpr double kWaitAtEnd = 2.0;       // s; for the last poses and diagnostics
constexpr double kMedian = 0.5, kHigh = 0.99;

/// Collects the dropped scans from the diagnostics of all nodes.
class DropWatcher {
 public:
  void onDiagnostics(const diagnostic_msgs::DiagnosticArray& message) {
    const std::string prefix = "dropped: ";
    for (const diagnostic_msgs::DiagnosticStatus& status : message.status) {
      for (const diagnostic_msgs::KeyValue& pair : status.values) {
        if (pair.key.compare(0, prefix.size(), prefix) != 0) continue;
        counts_[status.name + ", " + pair.key.substr(prefix.size())] = pair.value;
      }
    }
  }

  void print() const {
    for (const auto& [what, count] : counts_)
      std::printf("  %s: %s\n", what.c_str(), count.c_str());
  }

 private:
  std::map<std::string, std::string> counts_;
};

void waitForNodes(const LivePlayer& player, const ros::Subscriber& poses) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(kConnectWithin);
  while (!player.isHeard() || poses.getNumPublishers() == 0) {
    if (!ros::ok() || ros::WallTime::now() > end) {
      throw std::runtime_error(
          "there is no subscriber of its laser or IMU, or no publisher of poseupdate: first start "
          "roslaunch kestrel_slam mav.launch");
    }
    ros::WallDuration(0.1).sleep();
  }
  ros::WallDuration(1.0).sleep();  // wait for tf_static
}

void print(const LatencyRecord& record) {
  const std::vector<double> from_scan = record.fromScan(), from_last = record.fromLastInput();
  std::printf("scans %zu, dropped %zu", record.sentScans(), record.dropped());
  if (record.incomplete() > 0) {
    std::printf(" (and %zu at the end, newer than the last IMU message)", record.incomplete());
  }
  std::printf("\nlatency from the scan to its pose: median %.2f ms, p99 %.2f ms, max %.2f ms\n",
              quantile(from_scan, kMedian), quantile(from_scan, kHigh), quantile(from_scan, 1.0));
  std::printf(
      "of it, after the IMU's message that covers its last beam: median %.2f ms, p99 %.2f ms, max "
      "%.2f ms\n",
      quantile(from_last, kMedian), quantile(from_last, kHigh), quantile(from_last, 1.0));
}

void printAnswers(const char* topic, const LatencyRecord& record) {
  const std::vector<double> from_imu = record.fromImu();
  if (from_imu.empty()) return;  // no node answers
  std::printf(
      "latency from the IMU to %s: %zu messages, median %.2f ms, p99 %.2f ms, max %.2f ms\n", topic,
      from_imu.size(), quantile(from_imu, kMedian), quantile(from_imu, kHigh),
      quantile(from_imu, 1.0));
}

/// Records the arrival times of the answers on `topic`.
ros::Subscriber recordAnswers(ros::NodeHandle nh, const std::string& topic, LatencyRecord& record) {
  const boost::function<void(const nav_msgs::Odometry&)> on_answer =
      [&record](const nav_msgs::Odometry& message) { record.stateReceived(message.header.stamp); };
  return nh.subscribe<nav_msgs::Odometry>(topic, kQueue, on_answer, ros::VoidConstPtr(),
                                          ros::TransportHints().tcpNoDelay());
}

int echo() {
  ros::NodeHandle nh;
  const ros::Publisher publisher = nh.advertise<nav_msgs::Odometry>("odom/echo", kQueue);
  const boost::function<void(const sensor_msgs::Imu&)> answer =
      [&](const sensor_msgs::Imu& message) {
        nav_msgs::Odometry odometry;
        odometry.header = message.header;
        publisher.publish(odometry);
      };
  const ros::Subscriber imu = nh.subscribe<sensor_msgs::Imu>(
      "imu/data", kQueue, answer, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  ros::spin();
  return 0;
}

int run(const std::string& bag) {
  ros::NodeHandle nh;
  DropWatcher drops;
  LivePlayer player(nh, bag);
  LatencyRecord record(player.hasImu());
  const boost::function<void(const geometry_msgs::PoseWithCovarianceStamped&)> on_pose =
      [&](const geometry_msgs::PoseWithCovarianceStamped& message) {
        record.poseReceived(message.header.stamp);
      };
  const ros::Subscriber poses = nh.subscribe<geometry_msgs::PoseWithCovarianceStamped>(
      "poseupdate", kQueue, on_pose, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  LatencyRecord echoes(true);
  const ros::Subscriber states = recordAnswers(nh, "odom/filtered", record);
  const ros::Subscriber echoed = recordAnswers(nh, "odom/echo", echoes);
  // Subscribes to the map, to check that publishing it does not delay the poses.
  const boost::function<void(const nav_msgs::OccupancyGridConstPtr&)> on_map =
      [](const nav_msgs::OccupancyGridConstPtr&) {};
  const ros::Subscriber maps = nh.subscribe<nav_msgs::OccupancyGrid>("map", 1, on_map);
  const ros::Subscriber diagnostics =
      nh.subscribe("/diagnostics", kQueue, &DropWatcher::onDiagnostics, &drops);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  waitForNodes(player, poses);
  player.play([&](const LiveMessage& message) {
    record.sent(message);
    echoes.sent(message);
  });
  ros::WallDuration(kWaitAtEnd).sleep();
  spinner.stop();
  print(record);
  printAnswers("odom/filtered", record);
  printAnswers("a node that only answers", echoes);
  drops.print();
  return record.poses() > 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const bool is_echo = argc == 2 && std::string(argv[1]) == "--echo";
  ros::init(argc, argv, is_echo ? "latency_echo" : "measure_latency");
  if (is_echo) return echo();
  if (argc != 2 || std::string(argv[1]) == "--help" || std::string(argv[1]) == "-h") {
    std::fputs(kUsage, argc == 2 ? stdout : stderr);
    return argc == 2 ? 0 : 2;
  }
  try {
    return run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "measure_latency: %s: %s\n", argv[1], error.what());
    return 1;
  }
}
