// SPDX-License-Identifier: BSD-3-Clause
// Invalid input for the pose filter. It must not crash the filter or cause NaN in the output.

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/FluidPressure.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/Range.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "node_watcher.h"
#include "tilting_flight.h"

namespace kestrel {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPeriod = 0.01;  // s, of the IMU
constexpr double kGravity = 9.81;

/// A stationary vehicle with its sensors, and a pose filter node.
class PoseFilterGarbage : public ::testing::Test {
 protected:
  void SetUp() override {
    imu_ = nh_.advertise<sensor_msgs::Imu>("imu/data", 1000);
    pose_ = nh_.advertise<geometry_msgs::PoseWithCovarianceStamped>("poseupdate", 100);
    range_ = nh_.advertise<sensor_msgs::Range>("height", 100);
    pressure_ = nh_.advertise<sensor_msgs::FluidPressure>("imu/pressure", 100);
    const boost::function<void(const nav_msgs::Odometry&)> keep =
        [this](const nav_msgs::Odometry& message) { states_.push_back(message); };
    subscriber_ = nh_.subscribe<nav_msgs::Odometry>("odom/filtered", 1000, keep);
    mountings_.sendTransform(
        transformMessage("base_link", "imu_link", Eigen::Isometry3d::Identity(), now_));
    const Eigen::Isometry3d nose_down(Eigen::AngleAxisd(kPi / 2.0, Eigen::Vector3d::UnitY()));
    mountings_.sendTransform(transformMessage("base_link", "range_link", nose_down, now_));
    mountings_.sendTransform(
        transformMessage("base_link", "forward_link", Eigen::Isometry3d::Identity(), now_));
    ASSERT_TRUE(watcher_.waitFor([&] {
      return imu_.getNumSubscribers() > 0 && pose_.getNumSubscribers() > 0 &&
             range_.getNumSubscribers() > 0 && pressure_.getNumSubscribers() > 0 &&
             subscriber_.getNumPublishers() > 0;
    }));
    ros::ServiceClient reset = nh_.serviceClient<std_srvs::Trigger>("reset_filter");
    ASSERT_TRUE(reset.waitForExistence(ros::Duration(10.0)));
    // Every test starts with a converged filter. The clock continues between tests.
    now_ = ros::Time::now().toSec();
    std_srvs::Trigger trigger;
    ASSERT_TRUE(reset.call(trigger));
    ASSERT_TRUE(watcher_.waitFor([&] {
      stand(0.1);
      return !states_.empty() && states_.back().header.stamp.toSec() > now_ - 0.5;
    }));
  }

  void TearDown() override {
    for (const nav_msgs::Odometry& state : states_) {
      const auto& p = state.pose.pose.position;
      const auto& v = state.twist.twist.linear;
      ASSERT_TRUE(std::isfinite(p.x + p.y + p.z + v.x + v.y + v.z));
      for (const double element : state.pose.covariance) ASSERT_TRUE(std::isfinite(element));
      for (const double element : state.twist.covariance) ASSERT_TRUE(std::isfinite(element));
    }
  }

  sensor_msgs::Imu reading() {
    now_ += kPeriod;
    sensor_msgs::Imu message;
    message.header.stamp = ros::Time(now_);
    message.header.frame_id = "imu_link";
    message.orientation_covariance[0] = -1.0;
    const double noise = 1e-3 * std::sin(1e3 * now_);  // real sensors never repeat a value
    message.angular_velocity.x = noise;
    message.linear_acceleration.x = noise;
    message.linear_acceleration.z = kGravity + noise;
    return message;
  }

  void stand(double seconds) {
    for (double t = 0.0; t < seconds; t += kPeriod) imu_.publish(reading());
    watcher_.wait(0.02);
  }

  geometry_msgs::PoseWithCovarianceStamped poseAt(double stamp, const std::string& frame = "map") {
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.stamp = ros::Time(stamp);
    message.header.frame_id = frame;
    message.pose.pose.orientation.w = 1.0;
    for (const std::size_t i : {0U, 7U, 35U}) message.pose.covariance[i] = 1e-4;
    return message;
  }

  /// Continues to publish IMU data and calls `send` repeatedly until the diagnostics contain
  /// `text`.
  template <typename Send>
  void expectDiagnosis(const std::string& text, Send send) {
    std::string all;
    EXPECT_TRUE(watcher_.waitFor([&] {
      send();
      stand(0.05);
      all.clear();
      for (const auto& [key, value] : watcher_.report("Pose filter")) {
        all += key + ": " + value + "\n";
      }
      return all.find(text) != std::string::npos;
    })) << text
        << " is missing in the diagnostics:\n"
        << all;
  }

  ros::NodeHandle nh_;
  NodeWatcher watcher_{"pose_filter"};
  tf2_ros::StaticTransformBroadcaster mountings_;
  ros::Publisher imu_, pose_, range_, pressure_;
  ros::Subscriber subscriber_;
  std::vector<nav_msgs::Odometry> states_;
  double now_ = 1000.0;  ///< of the newest IMU message, s
};

TEST_F(PoseFilterGarbage, ReadingsThatAreNotFinite) {
  expectDiagnosis("imu: not finite", [&] {
    sensor_msgs::Imu broken = reading();
    broken.angular_velocity.y = kNan;
    imu_.publish(broken);
    broken = reading();
    broken.linear_acceleration.z = std::numeric_limits<double>::infinity();
    imu_.publish(broken);
  });
}

TEST_F(PoseFilterGarbage, InvalidPoses) {
  expectDiagnosis("last refusal: poses: the frame is 'odom', but must be 'map'",
                  [&] { pose_.publish(poseAt(now_, "odom")); });
  expectDiagnosis("refused: poses: invalid pose", [&] {
    auto pose = poseAt(now_);
    pose.pose.pose.position.x = kNan;
    pose_.publish(pose);
  });
  expectDiagnosis("pose: covariance", [&] {
    auto pose = poseAt(now_);
    pose.pose.covariance[0] = -1.0;
    pose_.publish(pose);
  });
  expectDiagnosis("pose: too old", [&] { pose_.publish(poseAt(now_ - 3600.0)); });
}

TEST_F(PoseFilterGarbage, InvalidHeights) {
  sensor_msgs::Range range;
  range.header.frame_id = "range_link";
  range.min_range = 0.1F;
  range.max_range = 10.0F;
  expectDiagnosis("range finder: not finite", [&] {
    range.header.stamp = ros::Time(now_);
    range.range = std::numeric_limits<float>::quiet_NaN();
    range_.publish(range);
  });
  expectDiagnosis("barometer: not finite", [&] {
    sensor_msgs::FluidPressure pressure;
    pressure.header.stamp = ros::Time(now_);
    pressure.fluid_pressure = -5.0;
    pressure_.publish(pressure);
  });
}

TEST_F(PoseFilterGarbage, RangeFindersThatDoNotLookDown) {
  for (const char* frame : {"forward_link", "nowhere_link"}) {
    expectDiagnosis("refused: heights: no mounting that looks down", [&] {
      sensor_msgs::Range range;
      range.header.frame_id = frame;
      range.header.stamp = ros::Time(now_);
      range.range = 1.0F;
      range_.publish(range);
    });
  }
}

TEST_F(PoseFilterGarbage, ImuWithoutTransform) {
  expectDiagnosis("nowhere_link", [&] {
    sensor_msgs::Imu strange = reading();
    strange.header.frame_id = "nowhere_link";
    imu_.publish(strange);
  });
}

TEST_F(PoseFilterGarbage, DiagnosticsDoNotGrowWithTheNamesOfFrames) {
  for (int i = 0; i < 300; ++i) {
    const std::string frame = std::to_string(i) + std::string(1000, 'x');
    sensor_msgs::Imu strange = reading();
    strange.header.frame_id = frame;
    imu_.publish(strange);
    pose_.publish(poseAt(now_, frame));
    if (i % 50 == 0) stand(0.05);
  }
  watcher_.wait(1.5);
  std::size_t bytes = 0;
  for (const auto& [key, value] : watcher_.report("Pose filter"))
    bytes += key.size() + value.size();
  EXPECT_GT(bytes, 100U);
  EXPECT_LT(bytes, 4000U);
}

TEST_F(PoseFilterGarbage, AFrozenImuIsReported) {
  sensor_msgs::Imu frozen = reading();
  ASSERT_TRUE(watcher_.waitFor([&] {
    for (int i = 0; i < 20; ++i) {
      now_ += kPeriod;
      frozen.header.stamp = ros::Time(now_);
      imu_.publish(frozen);
    }
    return watcher_.diagnosis("Pose filter", "level") == "2";
  }));
}

TEST_F(PoseFilterGarbage, ASilentImuIsReportedAndRecovers) {
  ASSERT_TRUE(watcher_.waitFor([&] { return watcher_.diagnosis("Pose filter", "level") == "2"; }));
  const std::size_t before = states_.size();
  now_ = ros::Time::now().toSec();
  ASSERT_TRUE(watcher_.waitFor([&] {
    stand(0.1);
    return states_.size() > before + 20;
  }));
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "pose_filter_garbage_test");
  return RUN_ALL_TESTS();
}
