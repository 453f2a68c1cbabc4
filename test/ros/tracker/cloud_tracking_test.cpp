// SPDX-License-Identifier: BSD-3-Clause
#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kestrel_slam/TrackArray.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sweep_messages.h"
#include "kestrel_slam/simulation/traffic.h"
#include "topic_nodes.h"
#include "tracker/collected.h"

namespace kestrel {
namespace {

constexpr int kFrames = 40;
constexpr double kPeriod = 0.1;

/// The crossing of [Siew 2018] with fewer columns. The lidar stands; its odometry drifts.
class CloudTrackingTest : public testing::Test {
 protected:
  static TrafficScene scene() {
    TrafficScene scene = crossingScene();
    scene.lidar.columns = 900;
    scene.frames = kFrames;
    return scene;
  }

  void start(const std::string& ns) {
    nh_ = ros::NodeHandle(ns);
    clouds_ = nh_.advertise<sensor_msgs::PointCloud2>("points", 10);
    tracks_ = std::make_unique<Collected<kestrel_slam::TrackArray>>(nh_, "tracks");
    markers_ = std::make_unique<Collected<visualization_msgs::MarkerArray>>(nh_, "track_markers");
    points_ = std::make_unique<Collected<sensor_msgs::PointCloud2>>(nh_, "moving_points");
    grid_ = std::make_unique<Collected<nav_msgs::OccupancyGrid>>(nh_, "dynamic_grid");
    for (int i = 0; i < 500 && !isConnected(); ++i) spinFor(0.02);
    ASSERT_TRUE(isConnected());
  }

  bool isConnected() const {
    return clouds_.getNumSubscribers() > 0 && tracks_->isConnected() && points_->isConnected() &&
           grid_->isConnected() && markers_->isConnected() && connections_.areComplete();
  }

  ros::Time stampOf(int frame) const { return start_ + ros::Duration(kPeriod * frame); }

  static Eigen::Isometry3d odomPose(int frame) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() << 10.0 + 0.02 * frame, 5.0, 1.73;
    pose.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return pose;
  }

  void sendPose(int frame, const std::string& child) {
    geometry_msgs::TransformStamped transform;
    transform.transform = toTransformMessage(odomPose(frame));
    transform.header.frame_id = "odom";
    transform.header.stamp = stampOf(frame);
    transform.child_frame_id = child;
    tf_.sendTransform(transform);
  }

  sensor_msgs::PointCloud2 cloudOf(const LabeledSweep& sweep, int frame) const {
    sensor_msgs::PointCloud2 message = toCloudMessage(sweep.cloud);
    message.header.frame_id = "velodyne";
    message.header.stamp = stampOf(frame);
    return message;
  }

  /// Sends a cloud that can be used, and waits until its tracks have come.
  void track(const sensor_msgs::PointCloud2& cloud) {
    const std::size_t before = tracks_->all.size();
    clouds_.publish(cloud);
    for (int i = 0; i < 500 && tracks_->all.size() == before; ++i) spinFor(0.01);
    ASSERT_EQ(tracks_->all.size(), before + 1) << cloud.header.stamp;
  }

  /// The value of the newest diagnostics of the tracker; "" without it.
  std::string diagnosticOf(const std::string& key) const {
    std::string value;
    for (const auto& array : diagnostics_.all) {
      for (const auto& status : array.status) {
        if (status.name != "tracker: Tracker") continue;  // not that of the other namespace
        for (const auto& pair : status.values) {
          if (pair.key == key) value = pair.value;
        }
      }
    }
    return value;
  }

  ros::NodeHandle nh_;
  const ros::Time start_ = ros::Time::now();
  ros::Publisher clouds_;
  tf2_ros::TransformBroadcaster tf_;
  TransformConnections connections_{nh_};
  std::unique_ptr<Collected<kestrel_slam::TrackArray>> tracks_;
  std::unique_ptr<Collected<visualization_msgs::MarkerArray>> markers_;
  std::unique_ptr<Collected<sensor_msgs::PointCloud2>> points_;
  std::unique_ptr<Collected<nav_msgs::OccupancyGrid>> grid_;
  Collected<diagnostic_msgs::DiagnosticArray> diagnostics_{nh_, "/diagnostics"};
};

/// Tracks with the place of something that moves, and others.
struct Comparison {
  int right = 0, wrong = 0;

  void add(const kestrel_slam::TrackArray& tracks, const LabeledSweep& sweep,
           const Eigen::Isometry3d& frame_T_lidar) {
    const Eigen::Isometry3d frame_T_world = frame_T_lidar * sweep.pose.inverse();
    for (const kestrel_slam::Track& track : tracks.tracks) {
      const Eigen::Vector3d position(track.position.x, track.position.y, track.position.z);
      bool found = false;
      for (const TrueBox& box : sweep.boxes) {
        found = found || (box.moving && (frame_T_world * box.center - position).norm() < 2.0);
      }
      (found ? right : wrong) += 1;
    }
  }
};

TEST_F(CloudTrackingTest, FollowsTrafficInTheFrameOfTheOdometry) {
  start("");
  const TrafficSimulator simulator(scene());
  Comparison comparison;
  for (int i = 0; i < kFrames; ++i) {
    const LabeledSweep sweep = simulator.sweep(i);
    clouds_.publish(cloudOf(sweep, i));
    spinFor(0.02);
    const std::size_t before = tracks_->all.size();
    sendPose(i, "velodyne");  // later than the cloud: the cloud waits for it
    for (int k = 0; k < 500 && tracks_->all.size() == before; ++k) spinFor(0.01);
    ASSERT_EQ(tracks_->all.size(), before + 1) << i;
    const kestrel_slam::TrackArray& tracks = tracks_->all.back();
    EXPECT_EQ(tracks.header.frame_id, "odom");
    EXPECT_EQ(tracks.header.stamp, stampOf(i));
    comparison.add(tracks, sweep, odomPose(i));
    for (const kestrel_slam::Track& track : tracks.tracks) EXPECT_GT(track.box_size.z, 0.0);
  }
  EXPECT_GT(comparison.right, 30);
  EXPECT_LT(comparison.wrong, comparison.right / 4);
  spinFor(1.5);
  EXPECT_GT(points_->all.back().width, 20U);
  EXPECT_EQ(points_->all.back().header.frame_id, "odom");
  EXPECT_GT(markers_->all.back().markers.size(), 3U);
  EXPECT_GT(grid_->all.back().info.width, 20U);
  EXPECT_EQ(diagnosticOf("used"), std::to_string(kFrames));
}

TEST_F(CloudTrackingTest, BadCloudsAreNamedAndTheNextGoodOneIsUsed) {
  start("");
  const TrafficSimulator simulator(scene());
  const LabeledSweep sweep = simulator.sweep(0);
  // The clocks of two tests differ: the tracker starts anew, or goes on.
  for (int i = 0; i < 3; ++i) {
    sendPose(i, "velodyne");
    track(cloudOf(sweep, i));
  }
  const std::size_t good = tracks_->all.size();
  const auto sendBad = [&](const sensor_msgs::PointCloud2& cloud) {
    clouds_.publish(cloud);
    spinFor(0.3);
  };
  for (int i = 3; i < 9; ++i) sendPose(i, "velodyne");
  sensor_msgs::PointCloud2 empty = cloudOf(sweep, 3);
  empty.width = empty.height = empty.row_step = 0;
  empty.data.clear();
  sendBad(empty);
  sensor_msgs::PointCloud2 no_fields = cloudOf(sweep, 3);
  no_fields.fields.clear();
  sendBad(no_fields);
  sensor_msgs::PointCloud2 truncated = cloudOf(sweep, 3);
  truncated.data.resize(truncated.data.size() / 2);
  sendBad(truncated);
  sensor_msgs::PointCloud2 invalid = cloudOf(sweep, 3);
  for (sensor_msgs::PointCloud2Iterator<float> x(invalid, "x"); x != x.end(); ++x) {
    *x = std::numeric_limits<float>::quiet_NaN();
  }
  sendBad(invalid);
  sensor_msgs::PointCloud2 elsewhere = cloudOf(sweep, 3);
  elsewhere.header.frame_id = "nowhere";
  sendBad(elsewhere);
  spinFor(0.5);
  sensor_msgs::PointCloud2 nameless = cloudOf(sweep, 3);
  nameless.header.frame_id = "";
  sendBad(nameless);
  sensor_msgs::PointCloud2 unstamped = cloudOf(sweep, 3);
  unstamped.header.stamp = ros::Time();
  sendBad(unstamped);
  sendBad(cloudOf(sweep, 2));  // not newer
  sendBad(cloudOf(sweep, 1));  // older
  sendPose(3, "other");
  sensor_msgs::PointCloud2 other = cloudOf(sweep, 3);
  other.header.frame_id = "other";
  sendBad(other);
  EXPECT_EQ(tracks_->all.size(), good);

  track(cloudOf(sweep, 4));
  spinFor(1.5);
  EXPECT_EQ(diagnosticOf("dropped: invalid"), "3");
  EXPECT_EQ(diagnosticOf("dropped: no transform"), "1");
  EXPECT_EQ(diagnosticOf("dropped: no frame"), "1");
  EXPECT_EQ(diagnosticOf("dropped: no stamp"), "1");
  EXPECT_EQ(diagnosticOf("dropped: not usable"), "4");  // NaN, not newer, older, other lidar

  // A clock that went back, as when a bag is played again: the tracker starts anew.
  sendPose(-20, "velodyne");
  track(cloudOf(sweep, -20));
}

// Only a lidar: its clouds give the odometry.
TEST_F(CloudTrackingTest, WithoutOdometryTheCloudsGiveIt) {
  start("/alone");
  tf2_ros::Buffer buffer;
  const tf2_ros::TransformListener listener(buffer);
  tf2_ros::StaticTransformBroadcaster mounting;
  geometry_msgs::TransformStamped car_T_lidar;
  car_T_lidar.header.frame_id = "car";
  car_T_lidar.child_frame_id = "hdl";
  car_T_lidar.transform.translation.z = 1.73;
  car_T_lidar.transform.rotation.w = 1.0;
  mounting.sendTransform(car_T_lidar);
  spinFor(0.5);
  const TrafficSimulator simulator(scene());
  Eigen::Isometry3d start_T_lidar = Eigen::Isometry3d::Identity();
  start_T_lidar.translation().z() = 1.73;
  Comparison comparison;
  for (int i = 0; i < kFrames; ++i) {
    const LabeledSweep sweep = simulator.sweep(i);
    sensor_msgs::PointCloud2 cloud = cloudOf(sweep, i);
    cloud.header.frame_id = "hdl";  // it has no other parent in tf
    track(cloud);
    if (HasFatalFailure()) return;
    EXPECT_EQ(tracks_->all.back().header.frame_id, "lidar_odom");
    comparison.add(tracks_->all.back(), sweep, start_T_lidar);
  }
  EXPECT_GT(comparison.right, 30);
  EXPECT_LT(comparison.wrong, comparison.right / 4);
  spinFor(0.2);
  const Eigen::Isometry3d pose =
      fromMessage(buffer.lookupTransform("lidar_odom", "car", stampOf(kFrames - 1)).transform);
  EXPECT_LT(pose.translation().norm(), 0.05);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  ros::init(argc, argv, "cloud_tracking_test");
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
