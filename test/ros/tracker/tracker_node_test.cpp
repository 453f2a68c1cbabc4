// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include <set>
#include <vector>

#include "kestrel_slam/TrackArray.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/ros/panel/mapper_summary.h"
#include "tracker/collected.h"
#include "tracking/walker_room.h"

namespace kestrel {
namespace {

class TrackerNodeTest : public testing::Test {
 protected:
  /// A subscriber knows its publisher before the publisher knows it, and tf tells nothing. So scans
  /// are sent until everything has come back. They are so old that the tracker then starts anew.
  void SetUp() override {
    scans_ = nh_.advertise<kestrel_slam::PlanarScan>("planar_scan", 200);
    const Pose2 pose;
    for (int i = 0; i < kWarmUp && !isConnected(); ++i) {
      sendScan(i - 2 * kWarmUp, pose, {});
      sendPose(i - 2 * kWarmUp, pose);
      spinFor(0.1);
    }
    ASSERT_TRUE(isConnected()) << tracks_.all.size() << " tracks, " << markers_.all.size()
                               << " markers, " << points_.all.size() << " points, "
                               << grid_.all.size() << " grids, " << diagnostics_.all.size()
                               << " diagnostics";
    spinFor(0.5);  // what is still on its way
    tracks_.all.clear();
    markers_.all.clear();
    points_.all.clear();
    grid_.all.clear();
  }

  bool isConnected() const {
    return !tracks_.all.empty() && !markers_.all.empty() && !points_.all.empty() &&
           !grid_.all.empty() && !diagnostics_.all.empty();
  }

  /// Gives the node time while it owes the tracks of more than `most` of the `sent` scans: its
  /// queue is short, and on a busy computer scans that do not wait for it are dropped.
  void waitForTracks(std::size_t sent, std::size_t most) {
    for (int i = 0; i < 250 && tracks_.all.size() + most < sent; ++i) spinFor(0.02);
  }

  ros::Time stampOf(int number) const { return start_ + ros::Duration(0.1 * number); }

  void sendPose(int number, const Pose2& pose) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "odom";
    transform.header.stamp = stampOf(number);
    transform.child_frame_id = "base_stabilized";
    transform.transform.translation.x = pose.x;
    transform.transform.translation.y = pose.y;
    transform.transform.rotation.z = std::sin(0.5 * pose.yaw);
    transform.transform.rotation.w = std::cos(0.5 * pose.yaw);
    tf_.sendTransform(transform);
  }

  void sendScan(int number, const Pose2& pose, const std::vector<Disk>& disks) {
    scans_.publish(
        toPlanarScanMessage(room_.scan(number, pose, disks), "base_stabilized", stampOf(number)));
  }

  static constexpr int kWarmUp = 200;  ///< scans, in 20 s

  ros::NodeHandle nh_;
  Room room_;
  const ros::Time start_ = ros::Time::now();
  ros::Publisher scans_;
  tf2_ros::TransformBroadcaster tf_;
  Collected<kestrel_slam::TrackArray> tracks_{nh_, "tracks"};
  Collected<visualization_msgs::MarkerArray> markers_{nh_, "track_markers"};
  Collected<sensor_msgs::PointCloud2> points_{nh_, "moving_points"};
  Collected<nav_msgs::OccupancyGrid> grid_{nh_, "dynamic_grid"};
  Collected<diagnostic_msgs::DiagnosticArray> diagnostics_{nh_, "/diagnostics"};
};

TEST_F(TrackerNodeTest, FollowsAWalkerWhileTheVehicleMoves) {
  constexpr int kScans = 70;
  for (int i = 0; i < kScans; ++i) {
    const Pose2 pose(-1.0 + 0.01 * i, -2.0, 0.005 * i);
    std::vector<Disk> disks{{{3.0, -3.0}, 0.1}};
    if (i >= 20) disks.push_back({{-3.0 + 0.1 * (i - 20), 2.0}, 0.15});
    sendScan(i, pose, disks);
    sendPose(i, pose);  // later than the scan: the scan waits for it
    spinFor(0.02);
    waitForTracks(static_cast<std::size_t>(i) + 1, 5);
  }
  waitForTracks(kScans, 0);
  spinFor(0.5);  // what comes after the last tracks
  ASSERT_EQ(tracks_.all.size(), static_cast<std::size_t>(kScans));
  std::set<std::int64_t> ids;
  std::size_t late = 0;
  for (const kestrel_slam::TrackArray& message : tracks_.all) {
    EXPECT_EQ(message.header.frame_id, "odom");
    const int number = static_cast<int>(std::lround((message.header.stamp - start_).toSec() / 0.1));
    for (const kestrel_slam::Track& track : message.tracks) {
      ids.insert(track.id);
      EXPECT_NEAR(track.position.x, -3.0 + 0.1 * (number - 20), 0.4);
      EXPECT_NEAR(track.position.y, 2.0, 0.4);
    }
    if (number >= 45 && message.tracks.size() == 1) ++late;
  }
  EXPECT_EQ(ids.size(), 1U);
  EXPECT_GE(late, 23U);
  EXPECT_FALSE(markers_.all.empty());
  ASSERT_FALSE(points_.all.empty());
  EXPECT_GT(points_.all.back().width, 2U);
  ASSERT_FALSE(grid_.all.empty());
  EXPECT_GT(grid_.all.back().info.width, 100U);

  MapperSummary panel;
  for (const auto& message : diagnostics_.all) takeOver(message, "", panel);
  EXPECT_NE(panel.tracks, "") << "what the panel of rviz shows";
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  ros::init(argc, argv, "tracker_node_test");
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
