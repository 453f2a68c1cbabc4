// SPDX-License-Identifier: BSD-3-Clause
// Projector, mapper and pose filter as live nodes on a simulated flight.

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <thread>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/recording/bag/bag_flight_writer.h"
#include "kestrel_slam/ros/latency/live_player.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "node_watcher.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kFlown = 20.0;  // s of the flight
constexpr double kImuRate = 100.0;
constexpr std::uint32_t kQueue = 10000;

/// A short flight through the laboratory and the output of the nodes.
class PoseFilterFlight : public ::testing::Test {
 protected:
  PoseFilterFlight() : place_(place("laboratory")) {
    place_.plan = randomPlan(place_, kFlown, 1);
    motion_ = flyQuadrotor(place_.plan, place_.quadrotor, 1);
    const World world(place_.parts);
    const VehicleModel vehicle = quadrotorWith("utm30lx");
    FlightSimulator flight(world, *motion_, vehicle, 1);
    writeFlightBag(folder_.file("flight.bag"), flight, vehicle);
  }

  void fly() {
    const boost::function<void(const nav_msgs::Odometry&)> keep =
        [&](const nav_msgs::Odometry& message) { states_.push_back(message); };
    const ros::Subscriber states = nh_.subscribe<nav_msgs::Odometry>("odom/filtered", kQueue, keep);
    LivePlayer player(nh_, folder_.file("flight.bag"));
    ASSERT_TRUE(
        watcher_.waitFor([&] { return player.isHeard() && states.getNumPublishers() > 0; }));
    watcher_.wait(1.0);  // wait for the mountings
    std::thread playing([&] {
      player.play([&](const LiveMessage& message) {
        const auto* imu = std::get_if<sensor_msgs::ImuPtr>(&message);
        if (imu == nullptr) return;
        if (sent_++ == 0) moved_ = (*imu)->header.stamp.toSec() - kFlightStart;
      });
      done_ = true;
    });
    watcher_.waitFor([&] { return done_.load(); }, 3.0 * motion_->duration() + 60.0);
    playing.join();
    watcher_.wait(1.0);
  }

  /// The true state at a stamp of the replay.
  TrueState truth(const ros::Time& stamp) const {
    return motion_->at(stamp.toSec() - moved_ - kFlightStart);
  }

  /// map_T_base of a state, computed with the newest map -> odom.
  Eigen::Isometry3d inMap(const nav_msgs::Odometry& state) {
    Eigen::Isometry3d odom_T_base = Eigen::Isometry3d::Identity();
    const auto& p = state.pose.pose.position;
    const auto& q = state.pose.pose.orientation;
    odom_T_base.translation() << p.x, p.y, p.z;
    odom_T_base.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
    Eigen::Isometry3d map_T_odom = Eigen::Isometry3d::Identity();
    for (const geometry_msgs::TransformStamped& transform : watcher_.transforms["odom"]) {
      if (transform.header.stamp > state.header.stamp) break;
      map_T_odom = fromMessage(transform.transform);
    }
    return map_T_odom * odom_T_base;
  }

  TemporaryFolder folder_;
  Place place_;
  std::unique_ptr<Motion> motion_;
  ros::NodeHandle nh_;
  NodeWatcher watcher_{"pose_filter"};
  NodeWatcher projector_{"projector"};
  std::vector<nav_msgs::Odometry> states_;
  std::size_t sent_ = 0;
  double moved_ = 0.0;  ///< time offset from the bag to the replay, s
  std::atomic<bool> done_{false};
};

TEST_F(PoseFilterFlight, TheStateMatchesTheTruth) {
  fly();
  ASSERT_GT(states_.size(), 100U);
  const double first_second = states_.front().header.stamp.toSec() + 1.0;
  EXPECT_NEAR(static_cast<double>(states_.size()), static_cast<double>(sent_),
              0.15 * static_cast<double>(sent_));

  // The map origin is the start of the filter. The truth is compared relative to it.
  const TrueState start = truth(states_.front().header.stamp);
  Eigen::Isometry3d start_T_world = Eigen::Isometry3d::Identity();
  start_T_world.rotate(Eigen::AngleAxisd(-yawOf(Eigen::Quaterniond(start.world_T_base.linear())),
                                         Eigen::Vector3d::UnitZ()));
  start_T_world.translation() = -(start_T_world.linear() * start.world_T_base.translation());
  start_T_world.translation().z() = 0.0;
  double worst_position = 0.0, worst_height = 0.0, worst_tilt = 0.0, worst_speed = 0.0;
  double worst_step = 0.0;
  for (std::size_t i = 1; i < states_.size(); ++i) {
    const nav_msgs::Odometry &before = states_[i - 1], &state = states_[i];
    ASSERT_EQ(state.header.frame_id, "odom");
    ASSERT_EQ(state.child_frame_id, "base_link");
    const double seconds = (state.header.stamp - before.header.stamp).toSec();
    ASSERT_GT(seconds, 0.0);
    const auto& v = state.twist.twist.linear;
    const Eigen::Vector3d velocity(v.x, v.y, v.z);
    const double step = std::hypot(state.pose.pose.position.x - before.pose.pose.position.x,
                                   state.pose.pose.position.y - before.pose.pose.position.y);
    worst_step = std::max(worst_step, step - 2.0 * velocity.norm() * seconds);
    if (state.header.stamp.toSec() < first_second) continue;
    const TrueState now = truth(state.header.stamp);
    const Eigen::Isometry3d expected = start_T_world * now.world_T_base;
    const Eigen::Isometry3d found = inMap(state);
    const Eigen::Vector3d error = found.translation() - expected.translation();
    worst_position = std::max(worst_position, error.head<2>().norm());
    worst_height = std::max(worst_height, std::abs(error.z()));
    const Eigen::Vector3d up = found.linear().row(2), true_up = expected.linear().row(2);
    worst_tilt = std::max(worst_tilt, std::acos(std::min(1.0, up.dot(true_up))));
    const Eigen::Vector3d true_velocity = now.world_T_base.linear().transpose() * now.velocity;
    worst_speed = std::max(worst_speed, (velocity - true_velocity).norm());
  }
  EXPECT_LT(worst_position, 0.1);
  EXPECT_LT(worst_height, 0.15);
  EXPECT_LT(radToDeg(worst_tilt), 1.5);
  EXPECT_LT(worst_speed, 0.3);
  EXPECT_LT(worst_step, 0.005);

  // The whole tf chain, with each transform once.
  using Names = std::set<std::string>;
  EXPECT_EQ(watcher_.parents["odom"], Names{"map"});
  EXPECT_EQ(watcher_.parents["base_footprint"], Names{"odom"});
  EXPECT_EQ(watcher_.parents["base_stabilized"], Names{"base_footprint"});
  EXPECT_EQ(watcher_.parents["base_link"], Names{"base_stabilized"});
  for (const char* child : {"odom", "base_footprint", "base_stabilized", "base_link"}) {
    const auto& transforms = watcher_.transforms[child];
    for (std::size_t i = 1; i < transforms.size(); ++i) {
      ASSERT_GT(transforms[i].header.stamp, transforms[i - 1].header.stamp) << child;
    }
  }

  auto report = watcher_.report("Pose filter");
  EXPECT_GT(std::atoi(report["pose: used"].c_str()), 100) << report["message"];
  EXPECT_GT(std::atoi(report["range finder: used"].c_str()), 50);
  EXPECT_EQ(projector_.diagnosis("Height", "source"), "pose filter");
  report = projector_.report("Scans");
  EXPECT_GT(std::atoi(report["projected by the filter"].c_str()), 200);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "pose_filter_flight_test");
  return RUN_ALL_TESTS();
}
