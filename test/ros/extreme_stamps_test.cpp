// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/FluidPressure.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MagneticField.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "kestrel_slam/FilteredMotion.h"
#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/PlanarScan.h"
#include "node_watcher.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 1000;
constexpr int kMessages = 10000;  ///< to each group of nodes
constexpr double kGravity = 9.81;

/// A message with a frame and otherwise values of zero, which the inputs take as far as possible.
template <typename Message>
Message plain(const std::string& frame) {
  Message message;
  message.header.frame_id = frame;
  return message;
}

/// Publishes one message with the given stamp.
using Source = std::function<void(const ros::Time&)>;

/// The topics of the nodes in one namespace.
class Vehicle {
 public:
  explicit Vehicle(const std::string& ns) : nh_(ns) {
    addSensors();
    addPoses();
    addTransforms();
  }

  void publish(std::size_t source, const ros::Time& stamp) {
    sources_[source % sources_.size()](stamp);
  }

  bool isConnected() const {
    for (const ros::Publisher& publisher : publishers_) {
      if (publisher.getNumSubscribers() == 0) return false;
    }
    return true;
  }

  /// A stationary vehicle with an IMU, on the clock of `stamp`.
  void publishImu(const ros::Time& stamp) {
    imu_.header.stamp = stamp;
    imu_.angular_velocity.x = imu_.angular_velocity.x > 0.0 ? 0.0 : 1e-3;  // it is not frozen
    publishers_[0].publish(imu_);
  }

 private:
  template <typename Message>
  void add(const std::string& topic, Message message) {
    publishers_.push_back(nh_.advertise<Message>(topic, kQueue));
    const ros::Publisher publisher = publishers_.back();
    sources_.push_back([publisher, message](const ros::Time& stamp) mutable {
      message.header.stamp = stamp;
      publisher.publish(message);
    });
  }

  void addSensors() {
    imu_ = plain<sensor_msgs::Imu>("base");
    imu_.orientation.w = 1.0;
    imu_.linear_acceleration.z = kGravity;
    add("imu/data", imu_);
    auto scan = plain<sensor_msgs::LaserScan>("base");
    scan.angle_min = -1.5F;
    scan.angle_increment = 0.03F;
    scan.range_max = 30.0F;
    scan.ranges.assign(100, 2.0F);
    add("scan", scan);
    auto range = plain<sensor_msgs::Range>("base_footprint");
    range.range = 1.0F;
    add("height", range);
    add("floor_height", range);
    add("points", plain<sensor_msgs::PointCloud2>("base"));
    auto pressure = plain<sensor_msgs::FluidPressure>("base");
    pressure.fluid_pressure = 1e5;
    add("imu/pressure", pressure);
    add("pressure_height", plain<geometry_msgs::PointStamped>("base"));
    auto field = plain<sensor_msgs::MagneticField>("base");
    field.magnetic_field.x = 4e-5;
    add("field", field);
    add("fix", plain<sensor_msgs::NavSatFix>("base"));
  }

  void addPoses() {
    add("odom/slam", plain<nav_msgs::Odometry>("map"));
    auto motion = plain<kestrel_slam::FilteredMotion>("odom");
    motion.orientation.w = 1.0;
    motion.gives_attitude = motion.gives_prediction = 1;
    add("filtered_motion", motion);
    auto state = plain<kestrel_slam::MapperState>("map");
    for (const std::size_t i : {0U, 4U, 8U}) state.covariance[i] = 1e-4;
    add("mapper_state", state);
    auto pose = plain<geometry_msgs::PoseWithCovarianceStamped>("map");
    pose.pose.pose.orientation.w = 1.0;
    add("poseupdate", pose);
    add("initialpose", pose);
    auto planar = plain<kestrel_slam::PlanarScan>("base_stabilized");
    planar.origin_x = planar.origin_y = planar.end_y = {0.0F, 0.0F};
    planar.end_x = {2.0F, 3.0F};
    planar.hit = {1, 1};
    add("planar_scan", planar);
  }

  void addTransforms() {
    for (const char* topic : {"/tf", "/tf_static"}) {
      publishers_.push_back(nh_.advertise<tf2_msgs::TFMessage>(topic, kQueue));
      const ros::Publisher publisher = publishers_.back();
      const std::string parent = std::string(topic) == "/tf" ? "odometry" : "level";
      const std::string child = std::string(topic) == "/tf" ? "level" : "base";
      sources_.push_back([publisher, parent, child](const ros::Time& stamp) {
        tf2_msgs::TFMessage message;
        message.transforms.resize(1);
        message.transforms[0].header.stamp = stamp;
        message.transforms[0].header.frame_id = parent;
        message.transforms[0].child_frame_id = child;
        message.transforms[0].transform.rotation.w = 1.0;
        publisher.publish(message);
      });
    }
  }

  ros::NodeHandle nh_;
  std::vector<ros::Publisher> publishers_;
  std::vector<Source> sources_;
  sensor_msgs::Imu imu_;
};

/// Stamps at the limits of all types that are involved, and at random.
ros::Time extremeStamp(std::mt19937& random) {
  constexpr std::uint32_t kLast = std::numeric_limits<std::uint32_t>::max();
  constexpr std::uint32_t kHalf = 1U << 31;
  const std::uint32_t seconds[] = {0,         1,          9,         kHalf - 1, kHalf,
                                   kHalf + 1, kLast - 10, kLast - 1, kLast};
  const std::uint32_t nanoseconds[] = {0, 1, 999999999, 1000000000, kHalf, kLast};
  ros::Time stamp;
  stamp.sec = random() % 4 == 0 ? static_cast<std::uint32_t>(random())
                                : seconds[random() % std::size(seconds)];
  stamp.nsec = nanoseconds[random() % std::size(nanoseconds)];
  return stamp;
}

class ExtremeStamps : public testing::TestWithParam<const char*> {};

TEST_P(ExtremeStamps, EndNoNode) {
  const std::string ns = GetParam();
  Vehicle vehicle(ns);
  NodeWatcher projector(ns + "/projector"), mapper(ns + "/mapper"),
      planar_mapper(ns + "/planar_mapper"), filter(ns + "/pose_filter");
  ASSERT_TRUE(projector.waitFor([&] { return vehicle.isConnected(); }));
  std::mt19937 random(1);
  for (int i = 0; i < kMessages; ++i) {
    vehicle.publish(random(), extremeStamp(random));
    if (i % 20 == 0) projector.wait(0.002);
  }
  EXPECT_FALSE(projector.report("Scans").empty()) << "the projector has ended";
  EXPECT_FALSE(mapper.report("Scans").empty()) << "the mapper has ended";
  EXPECT_FALSE(planar_mapper.report("Scans").empty()) << "the mapper of planar scans has ended";
  EXPECT_FALSE(filter.report("Pose filter").empty()) << "the pose filter has ended";
}

/// The stamps that have come so far must not reach tf, nor hide later ones.
TEST_P(ExtremeStamps, AreNotPublishedAndDoNoLastingHarm) {
  const std::string ns = GetParam();
  Vehicle vehicle(ns);
  NodeWatcher watcher(ns + "/projector");
  ASSERT_TRUE(watcher.waitFor([&] { return vehicle.isConnected(); }));
  vehicle.publishImu(ros::Time(1699999998, 0));  // two agreeing stamps set the clock
  vehicle.publishImu(ros::Time(1699999999, 0));
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    vehicle.publishImu(ros::Time(1700000000 + i / 100, i % 100 * 10000000));
    vehicle.publishImu(extremeStamp(random));
    watcher.wait(0.01);
  }
  const auto& transforms = watcher.transforms["base_stabilized"];
  ASSERT_GT(transforms.size(), 100U);
  for (const auto& transform : transforms) EXPECT_LT(transform.header.stamp.sec, 1700000003U);
}

INSTANTIATE_TEST_SUITE_P(All, ExtremeStamps, testing::Values("nodes", "nodelets"));

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "extreme_stamps_test");
  return RUN_ALL_TESTS();
}
