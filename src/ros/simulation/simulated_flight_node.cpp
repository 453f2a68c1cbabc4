// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/simulation/simulated_flight_node.h"

#include <ros/console.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <variant>

#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/recording/bag/bag_flight_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/private_parameters.h"
#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {
namespace {

constexpr double kTick = 0.005;       // s of wall time
constexpr std::uint32_t kQueue = 50;  // messages

}  // namespace

std::vector<Parameter> parametersOf(SimulatedFlightConfig& config) {
  using namespace parameter_table;
  constexpr double kMinSpeed = 0.01, kMaxSpeed = 100.0, kLongest = 3600.0, kMaxSeed = 1e9;
  return group(
      "Flight",
      {text("world", &config.world, "Where to fly; `simulate_flight --list` shows the names."),
       text("sensor", &config.sensor,
            "Laser or 3D lidar; `simulate_flight --list` shows the names."),
       number("speed", "", &config.speed, kMinSpeed, kMaxSpeed,
              "Speed of the time; 2: twice as fast as in reality."),
       number("random_time", "s", &config.random_time, 0.0, kLongest,
              "Duration of a random flight; 0: the flight of the world."),
       number("start_delay", "s", &config.start_delay, 0.0, kLongest,
              "Wall time before the start, in which the other nodes start."),
       number("seed", "", &config.seed, 0.0, kMaxSeed, "Seed of wind, noise and random flight."),
       flag("level", &config.level, "Fly the same path without roll and pitch."),
       flag("raw_imu", &config.raw_imu, "The IMU gives no orientation.")});
}

SimulatedFlightNode::SimulatedFlightNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh) {
  readPrivateParameters(private_nh, parametersOf(config_), {});
  const auto seed = static_cast<std::uint64_t>(config_.seed);
  Place chosen = place(config_.world);
  chosen.quadrotor.level = config_.level;
  if (config_.random_time > 0.0) chosen.plan = randomPlan(chosen, config_.random_time, seed);
  vehicle_ = quadrotorWith(config_.sensor);
  vehicle_.imu->gives_orientation = !config_.raw_imu;
  world_ = std::make_unique<World>(chosen.parts);
  motion_ = flyQuadrotor(chosen.plan, chosen.quadrotor, seed);
  flight_ = std::make_unique<FlightSimulator>(*world_, *motion_, vehicle_, seed);
  flying_ = flight_->next(next_);
  advertise(nh);
  start_ = ros::WallTime::now() + ros::WallDuration(config_.start_delay);
  timer_ = nh.createWallTimer(ros::WallDuration(kTick), [this](const ros::WallTimerEvent&) {
    guarded("the flight", [this] { tick(); });
  });
  ROS_INFO("A quadrotor flies through the world '%s' for %.0f s.", config_.world.c_str(),
           motion_->duration());
}

void SimulatedFlightNode::advertise(ros::NodeHandle& nh) {
  clock_ = nh.advertise<rosgraph_msgs::Clock>("/clock", 1);
  mountings_ = nh.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
  scan_ = nh.advertise<sensor_msgs::LaserScan>("scan", kQueue);
  points_ = nh.advertise<sensor_msgs::PointCloud2>("points", kQueue);
  imu_ = nh.advertise<sensor_msgs::Imu>("imu/data", kQueue);
  height_ = nh.advertise<sensor_msgs::Range>("height", kQueue);
  pressure_height_ = nh.advertise<geometry_msgs::PointStamped>("pressure_height", kQueue);
  truth_ = nh.advertise<nav_msgs::Odometry>("ground_truth", kQueue);
  people_ = nh.advertise<geometry_msgs::PoseArray>("people", kQueue);
  mountings_.publish(mountings(vehicle_, ros::Time(kFlightStart)));
}

/// Publishes everything that has arrived by now. The clock stands still before the start.
void SimulatedFlightNode::tick() {
  const double flown = (ros::WallTime::now() - start_).toSec() * config_.speed;
  const double now = kFlightStart + std::max(flown, 0.0);
  while (flying_ && next_.arrival <= now && flown >= 0.0) {
    publishClock(next_.arrival);
    publish(next_);
    flying_ = flight_->next(next_);
    if (!flying_) ROS_INFO("The flight has ended; the map stays until Ctrl+C.");
  }
  publishClock(now);
}

void SimulatedFlightNode::publishClock(double time) {
  rosgraph_msgs::Clock clock;
  clock.clock = ros::Time(time);
  clock_.publish(clock);
}

void SimulatedFlightNode::publish(const FlightEvent& event) {
  const auto publisherOf = [this](const auto& message) -> const ros::Publisher& {
    using Message = std::decay_t<decltype(message)>;
    if constexpr (std::is_same_v<Message, LaserScan>) return scan_;
    if constexpr (std::is_same_v<Message, PointCloud>) return points_;
    if constexpr (std::is_same_v<Message, ImuSample>) return imu_;
    if constexpr (std::is_same_v<Message, HeightSample>) return height_;
    if constexpr (std::is_same_v<Message, Barometer>) return pressure_height_;
    if constexpr (std::is_same_v<Message, TruePose>) return truth_;
    if constexpr (std::is_same_v<Message, TrueWalkers>) return people_;
  };
  std::visit(
      [&](const auto& message) {
        publisherOf(message).publish(toMessage(message, ros::Time(event.stamp), vehicle_));
      },
      event.message);
}

}  // namespace kestrel
