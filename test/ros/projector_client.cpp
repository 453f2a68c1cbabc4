// SPDX-License-Identifier: BSD-3-Clause
#include "projector_client.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "kestrel_slam/messages/planar_scan_message.h"
#include "topic_nodes.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 1000;
constexpr double kImuPeriod = 0.005;   // s
constexpr double kScanPeriod = 0.025;  // s
constexpr float kTolerance_m = 1e-3F;
constexpr double kSlice_m = 1.5;    // the default value, above and below the laser
constexpr double kLimit_m = 0.005;  // closer to the slice limits, a beam may be inside or outside
constexpr std::size_t kAtTheLimits = 8;  // allowed number of beams there

float distanceToNearest(const Eigen::Vector2f& point, const std::vector<Eigen::Vector2f>& others) {
  float nearest = std::numeric_limits<float>::infinity();
  for (const Eigen::Vector2f& other : others) nearest = std::min(nearest, (point - other).norm());
  return nearest;
}

}  // namespace

ProjectorClient::ProjectorClient(const std::string& ns)
    : NodeWatcher(ns + "/scan_projector"), nh(ns), ns_(ns) {
  scan_publisher = nh.advertise<sensor_msgs::LaserScan>("scan", kQueue);
  imu_publisher = nh.advertise<sensor_msgs::Imu>("imu/data", kQueue);
  cloud_publisher = nh.advertise<sensor_msgs::PointCloud2>("points", kQueue);
  constexpr bool kLatch = true;
  mounting_publisher_ = nh.advertise<tf2_msgs::TFMessage>("/tf_static", 1, kLatch);
  const boost::function<void(const kestrel_slam::PlanarScanConstPtr&)> on_planar_scan =
      [this](const kestrel_slam::PlanarScanConstPtr& message) {
        planar_scans[message->header.stamp] = message;
      };
  subscribers_.push_back(
      nh.subscribe<kestrel_slam::PlanarScan>("planar_scan", kQueue, on_planar_scan));
}

bool ProjectorClient::connect(bool with_imu) {
  return connect({scan_publisher, cloud_publisher}, with_imu);
}

bool ProjectorClient::connect(const std::vector<ros::Publisher>& lasers, bool with_imu) {
  constexpr double kSettle = 0.3;  // s; time from a connection to the arrival of the mountings
  const auto is_heard = [](const ros::Publisher& laser) { return laser.getNumSubscribers() > 0; };
  const auto listens = [&] {
    return std::all_of(lasers.begin(), lasers.end(), is_heard) &&
           (!with_imu || imu_publisher.getNumSubscribers() > 0) &&
           subscribers_[0].getNumPublishers() > 0 &&
           mounting_publisher_.getNumSubscribers() >= nodesOf("/tf_static").subscribers;
  };
  const bool connected = waitFor(listens);
  wait(kSettle);
  return connected;
}

void ProjectorClient::mount(const std::string& name, const Eigen::Isometry3d& base_T_sensor) {
  mountings_.transforms.push_back(
      transformMessage(frame("base"), frame(name), base_T_sensor, time));
  mounting_publisher_.publish(mountings_);
}

void ProjectorClient::flyImu(double end) {
  for (; imu_time < end; imu_time += kImuPeriod) {
    imu_publisher.publish(flight.imu(imu_time, frame("imu"), base_R_imu));
  }
}

sensor_msgs::LaserScan ProjectorClient::nextScan() {
  const sensor_msgs::LaserScan scan = flight.scan(time, frame("laser"), base_T_laser);
  time += kScanPeriod;
  return scan;
}

std::optional<PlanarScan> ProjectorClient::project(const sensor_msgs::LaserScan& scan,
                                                   double timeout_s) {
  scan_publisher.publish(scan);
  const ros::Time stamp = scan.header.stamp;
  if (!waitFor([&] { return planar_scans.count(stamp) > 0; }, timeout_s)) return std::nullopt;
  return fromPlanarScanMessage(*planar_scans[stamp]);
}

void ProjectorClient::flyOn() {
  const double start = time;
  imu_time = std::max(imu_time, start - 2.0 * kScanPeriod);
  flyImu(start + kScanPeriod);
  expectRight(project(nextScan()), start, base_T_laser);
}

void ProjectorClient::expectRight(const std::optional<PlanarScan>& scan, double scan_time,
                                  const Eigen::Isometry3d& mounting) const {
  ASSERT_TRUE(scan) << "no planar scan for " << scan_time;
  const std::vector<Eigen::Vector2f> expected = flight.hits(scan_time, mounting, kSlice_m);
  const std::vector<Eigen::Vector2f> possible =
      flight.hits(scan_time, mounting, kSlice_m + kLimit_m);
  float worst = 0.0F;
  for (const PlanarRay& ray : scan->rays) {
    if (ray.hit) worst = std::max(worst, distanceToNearest(ray.end, possible));
  }
  EXPECT_LT(worst, kTolerance_m) << "at " << scan_time;
  const auto difference = static_cast<long>(scan->hitCount()) - static_cast<long>(expected.size());
  EXPECT_LE(std::abs(difference), static_cast<long>(kAtTheLimits)) << expected.size();
  EXPECT_GT(scan->hitCount(), expected.size() / 2);
}

}  // namespace kestrel
