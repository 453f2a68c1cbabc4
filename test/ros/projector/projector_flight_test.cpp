// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "projector_client.h"

namespace kestrel {
namespace {

constexpr double kScanPeriod = 0.025;  // s

/// The points of a scan in the laser frame, each with its time relative to the stamp.
sensor_msgs::PointCloud2 cloudOf(const sensor_msgs::LaserScan& scan) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = scan.header;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  using sensor_msgs::PointField;
  modifier.setPointCloud2Fields(4, "x", 1, PointField::FLOAT32, "y", 1, PointField::FLOAT32, "z", 1,
                                PointField::FLOAT32, "time", 1, PointField::FLOAT32);
  modifier.resize(scan.ranges.size());
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z"),
      time(cloud, "time");
  for (std::size_t i = 0; i < scan.ranges.size(); ++i, ++x, ++y, ++z, ++time) {
    const auto beam = static_cast<float>(i);
    const float angle = scan.angle_min + beam * scan.angle_increment;
    *x = scan.ranges[i] * std::cos(angle);
    *y = scan.ranges[i] * std::sin(angle);
    *z = 0.0F;
    *time = beam * scan.time_increment;
  }
  return cloud;
}

Eigen::Quaterniond rotationOf(const geometry_msgs::TransformStamped& transform) {
  const auto& q = transform.transform.rotation;
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z);
}

TEST(ProjectorFlight, TiltedLaserGivesTheTrueWalls) {
  ProjectorClient client("tilted");
  client.mount("laser", client.base_T_laser);
  client.mount("imu", Eigen::Isometry3d::Identity());
  ASSERT_TRUE(client.connect());
  for (int i = 0; i < 40; ++i) client.flyOn();
  EXPECT_EQ(client.planar_scans.size(), 40U);
  auto report = client.report("Attitude");
  EXPECT_EQ(report["level"], "0") << report["message"];
  EXPECT_EQ(report["health"], "ok");
  report = client.report("Scans");
  EXPECT_EQ(report["received"], "40");
  EXPECT_EQ(report["projected"], "40");
  EXPECT_EQ(report["level"], "0") << report["message"];

  const kestrel_slam::PlanarScan& message = *client.planar_scans.begin()->second;
  EXPECT_EQ(message.header.frame_id, "tilted_stabilized");
  const double turned =
      *fromPlanarScanMessage(*client.planar_scans.rbegin()->second).integrated_yaw -
      *fromPlanarScanMessage(message).integrated_yaw;
  EXPECT_NEAR(turned, 39 * kScanPeriod * client.flight.yaw_rate, 1e-3);
}

TEST(ProjectorFlight, PublishesRollAndPitchOfEveryImuMessage) {
  ProjectorClient client("frames");
  client.mount("laser", client.base_T_laser);
  client.mount("imu", Eigen::Isometry3d::Identity());
  ASSERT_TRUE(client.connect());
  client.flyOn();
  const double first = client.imu_time;
  client.flyImu(first + 0.5);
  client.imu_publisher.publish(client.flight.imu(client.imu_time - 0.005, "frames_imu"));  // again
  client.flyOn();
  const auto& tilts = client.transforms["frames_base"];
  ASSERT_TRUE(client.waitFor([&] {
    return !tilts.empty() && tilts.back().header.stamp.toSec() > client.imu_time - 0.006;
  }));
  EXPECT_EQ(client.parents["frames_base"], std::set<std::string>{"frames_stabilized"});
  EXPECT_EQ(client.parents["frames_stabilized"], std::set<std::string>{"frames_footprint"});
  ros::Time last;
  for (const geometry_msgs::TransformStamped& tilt : tilts) {
    EXPECT_GT(tilt.header.stamp, last);
    last = tilt.header.stamp;
    const Eigen::Quaterniond expected = withoutYaw(client.flight.world_R_base(last.toSec()));
    EXPECT_LT(rotationOf(tilt).angularDistance(expected), 1e-5);
    EXPECT_EQ(tilt.transform.translation.z, 0.0);
  }
  EXPECT_EQ(client.transforms["frames_stabilized"].size(), tilts.size());
  EXPECT_EQ(client.transforms["frames_stabilized"].back().transform.translation.z, 0.0);
}

TEST(ProjectorFlight, WaitsForALateImu) {
  ProjectorClient client("late");
  client.mount("laser", client.base_T_laser);
  client.mount("imu", Eigen::Isometry3d::Identity());
  ASSERT_TRUE(client.connect());
  client.flyOn();
  for (int i = 0; i < 5; ++i) {
    const double time = client.time;
    EXPECT_FALSE(client.project(client.nextScan(), 0.2)) << "there is no attitude yet";
    client.flyImu(time + kScanPeriod);
    const ros::Time stamp(time);
    ASSERT_TRUE(client.waitFor([&] { return client.planar_scans.count(stamp) > 0; }));
    client.expectRight(fromPlanarScanMessage(*client.planar_scans[stamp]), time,
                       client.base_T_laser);
  }
  EXPECT_EQ(client.diagnosis("Scans", "projected"), "6");
}

TEST(ProjectorFlight, AnyMountingOfTheImu) {
  ProjectorClient client("mounted");
  const Eigen::Isometry3d base_T_imu = mounting(0.0, 0.0, 0.0, kPi - 0.3, 0.4, 2.0);
  client.base_R_imu = base_T_imu.linear();
  client.mount("laser", client.base_T_laser);
  client.mount("imu", base_T_imu);
  ASSERT_TRUE(client.connect());
  for (int i = 0; i < 5; ++i) client.flyOn();
}

TEST(ProjectorFlight, EveryLaserHasItsOwnMounting) {
  ProjectorClient client("two");
  const Eigen::Isometry3d base_T_front = client.base_T_laser;
  const Eigen::Isometry3d base_T_back = mounting(-0.2, 0.0, -0.1, kPi, 0.02, kPi);  // upside down
  client.mount("laser", base_T_front);
  client.mount("back", base_T_back);
  client.mount("imu", Eigen::Isometry3d::Identity());
  ros::Publisher front = client.nh.advertise<sensor_msgs::LaserScan>("front_scan", 10);
  ros::Publisher back = client.nh.advertise<sensor_msgs::LaserScan>("back_scan", 10);
  ASSERT_TRUE(client.connect({front, back}, true));
  client.flyImu(client.time + 0.2);
  for (int i = 0; i < 5; ++i) {
    const double time = client.time, back_time = time + 0.01;
    front.publish(client.nextScan());
    back.publish(client.flight.scan(back_time, "two_back", base_T_back));
    ASSERT_TRUE(client.waitFor([&] {
      return client.planar_scans.count(ros::Time(time)) > 0 &&
             client.planar_scans.count(ros::Time(back_time)) > 0;
    }));
    const auto scanAt = [&](double t) {
      return fromPlanarScanMessage(*client.planar_scans[ros::Time(t)]);
    };
    client.expectRight(scanAt(time), time, base_T_front);
    client.expectRight(scanAt(back_time), back_time, base_T_back);
  }
}

TEST(ProjectorFlight, CloudsWithTheTimesOfTheirPoints) {
  ProjectorClient client("cloud");
  client.mount("laser", client.base_T_laser);
  client.mount("imu", Eigen::Isometry3d::Identity());
  ASSERT_TRUE(client.connect());
  client.flyImu(client.time + kScanPeriod);
  const double time = client.time;
  client.cloud_publisher.publish(cloudOf(client.nextScan()));
  const ros::Time stamp(time);
  ASSERT_TRUE(client.waitFor([&] { return client.planar_scans.count(stamp) > 0; }));
  const PlanarScan scan = fromPlanarScanMessage(*client.planar_scans[stamp]);
  const std::vector<Eigen::Vector2f> expected =
      client.flight.hits(time, client.base_T_laser, 1.505);
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.hit) continue;
    float nearest = 1.0F;
    for (const Eigen::Vector2f& end : expected) nearest = std::min(nearest, (end - ray.end).norm());
    EXPECT_LT(nearest, 1e-3F);
  }
  EXPECT_GT(scan.hitCount(), 400U);  // of 810 bins of 1/3 degree
}

TEST(ProjectorFlight, AttitudeFromTf) {
  ProjectorClient client("tf");
  client.mount("laser", client.base_T_laser);
  ASSERT_TRUE(client.connect(false));
  tf2_ros::TransformBroadcaster broadcaster;
  const auto publishAttitude = [&](double from, double to) {
    for (double time = from; time <= to; time += 0.005) {
      Eigen::Isometry3d world_T_base = Eigen::Isometry3d::Identity();
      world_T_base.linear() = client.flight.world_R_base(time).toRotationMatrix();
      broadcaster.sendTransform(transformMessage("tf_world", "tf_base", world_T_base, time));
    }
  };
  const auto reachesTheNode = [&] {  // the first messages of a publisher can be lost
    publishAttitude(client.time - 0.01, client.time + kScanPeriod);
    return client.project(client.nextScan(), 0.2).has_value();
  };
  ASSERT_TRUE(client.waitFor(reachesTheNode));
  const std::string before = client.diagnosis("Scans", "dropped: no-attitude-in-tf");
  for (int i = 0; i < 5; ++i) {
    const double time = client.time;
    EXPECT_FALSE(client.project(client.nextScan(), 0.1));
    publishAttitude(time - 0.01, time + kScanPeriod);
    const ros::Time stamp(time);
    ASSERT_TRUE(client.waitFor([&] { return client.planar_scans.count(stamp) > 0; }));
    client.expectRight(fromPlanarScanMessage(*client.planar_scans[stamp]), time,
                       client.base_T_laser);
  }
  EXPECT_EQ(client.parents["tf_base"], std::set<std::string>{"tf_world"})
      << "the base already has a parent";

  client.scan_publisher.publish(client.nextScan());  // tf has no data at its time
  ASSERT_TRUE(client.waitFor(
      [&] { return client.diagnosis("Scans", "dropped: no-attitude-in-tf") > before; }));
  auto report = client.report("Attitude");
  EXPECT_EQ(report["level"], "2");
  EXPECT_NE(report["message"].find("'tf_world' -> 'tf_base'"), std::string::npos)
      << report["message"];
}

TEST(ProjectorFlight, LevelLaserNeedsNoImu) {
  ProjectorClient client("level");
  client.flight = {0.0, 0.0, 0.0};
  client.base_T_laser = mounting(0.1, -0.05, 0.08, 0.0, 0.0, 0.3);
  client.mount("laser", client.base_T_laser);
  ASSERT_TRUE(client.connect(false));
  const double time = client.time;
  const std::optional<PlanarScan> scan = client.project(client.nextScan());
  client.expectRight(scan, time, client.base_T_laser);
  EXPECT_FALSE(scan->integrated_yaw);
  ASSERT_TRUE(client.waitFor([&] { return client.transforms.count("level_base") > 0; }));
  EXPECT_EQ(rotationOf(client.transforms["level_base"].front()).w(), 1.0);
  EXPECT_EQ(client.report("Attitude")["level"], "0");
}

TEST(ProjectorFlight, WithoutImuScansCanBeAssumedLevel) {
  ProjectorClient client("fallback");
  client.flight = {0.0, 0.0, 0.0};
  client.base_T_laser = mounting(0.0, 0.0, 0.1, 0.0, 0.0, 0.0);
  client.mount("laser", client.base_T_laser);
  client.mount("imu", Eigen::Isometry3d::Identity());
  ASSERT_TRUE(client.connect());
  const double time = client.time;
  client.expectRight(client.project(client.nextScan()), time, client.base_T_laser);
  EXPECT_EQ(client.diagnosis("Scans", "projected without attitude"), "1");
  client.flight = TiltingFlight();
  client.flyImu(client.time);  // the IMU sends data from now on, so scans wait for it
  ASSERT_TRUE(client.waitFor([&] { return client.transforms["fallback_base"].size() > 1; }));
  for (int i = 0; i < 3; ++i) client.flyOn();
  EXPECT_EQ(client.diagnosis("Scans", "projected without attitude"), "1");
}

TEST(ProjectorFlight, VelocityOfTheOdometryCorrectsTheMotion) {
  ProjectorClient client("moving");
  client.mount("laser", Eigen::Isometry3d::Identity());
  ros::Publisher odometry = client.nh.advertise<nav_msgs::Odometry>("odom/slam", 10);
  ASSERT_TRUE(client.connect(false));
  ASSERT_TRUE(client.waitFor([&] { return odometry.getNumSubscribers() > 0; }));
  sensor_msgs::LaserScan scan = client.nextScan();
  scan.ranges.assign(scan.ranges.size(), 2.0F);
  nav_msgs::Odometry motion;
  motion.header.stamp = scan.header.stamp;
  motion.child_frame_id = "moving_base";
  motion.twist.twist.linear.x = 3.0;
  motion.twist.twist.linear.y = -1.0;
  odometry.publish(motion);
  client.wait(0.3);
  const std::optional<PlanarScan> planar = client.project(scan);
  ASSERT_TRUE(planar);
  ASSERT_EQ(planar->rays.size(), scan.ranges.size());
  const PlanarRay& last = planar->rays.back();
  const auto moved = static_cast<float>(TiltingFlight::kSweep);
  EXPECT_NEAR(last.origin.x(), 3.0F * moved, 1e-4F);
  EXPECT_NEAR(last.origin.y(), -1.0F * moved, 1e-4F);
  EXPECT_NEAR(last.end.x(), 2.0F * std::cos(0.75F * static_cast<float>(kPi)) + 3.0F * moved, 1e-3F);
}

TEST(ProjectorFlight, MirrorMeasuresTheHeight) {
  ProjectorClient client("mirror");
  constexpr double kHeight = 1.5, kMirrorDistance = 0.1, kLaserHeight = 0.08;  // m
  client.mount("laser", mounting(0.0, 0.0, kLaserHeight, 0.0, 0.0, 0.0));
  std::vector<sensor_msgs::Range> heights;
  const boost::function<void(const sensor_msgs::Range&)> keep =
      [&](const sensor_msgs::Range& message) { heights.push_back(message); };
  const ros::Subscriber subscriber = client.nh.subscribe<sensor_msgs::Range>("height", 10, keep);
  ASSERT_TRUE(client.connect(false));
  ASSERT_TRUE(client.waitFor([&] { return subscriber.getNumPublishers() > 0; }));
  sensor_msgs::LaserScan scan = client.nextScan();
  const auto on_floor = static_cast<float>(kMirrorDistance + kLaserHeight + kHeight);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const float angle = scan.angle_min + static_cast<float>(i) * scan.angle_increment;
    scan.ranges[i] = angle > 2.0F ? on_floor : 3.0F;  // mirror_angles: 115:135
  }
  ASSERT_TRUE(client.project(scan));
  ASSERT_TRUE(client.waitFor([&] { return !heights.empty(); }));
  EXPECT_NEAR(heights[0].range, kHeight, 1e-4);
  EXPECT_EQ(heights[0].header.stamp, scan.header.stamp);
  EXPECT_EQ(heights[0].header.frame_id, "mirror_stabilized");

  scan = client.nextScan();
  scan.ranges.assign(scan.ranges.size(), on_floor);
  ASSERT_TRUE(client.project(scan));
  EXPECT_NEAR(std::stod(client.diagnosis("Height", "height (m)")), kHeight, 1e-3);
  const auto& footprints = client.transforms["mirror_stabilized"];
  ASSERT_TRUE(client.waitFor([&] { return footprints.size() >= 2; }));
  EXPECT_NEAR(footprints.back().transform.translation.z, kHeight, 1e-3);
}

TEST(ProjectorFlight, ViewForOtherPackages) {
  ProjectorClient client("view");
  client.mount("laser", Eigen::Isometry3d::Identity());
  sensor_msgs::LaserScan view;
  const boost::function<void(const sensor_msgs::LaserScan&)> keep =
      [&](const sensor_msgs::LaserScan& message) { view = message; };
  const ros::Subscriber subscriber =
      client.nh.subscribe<sensor_msgs::LaserScan>("planar_scan_view", 10, keep);
  ASSERT_TRUE(client.connect(false));
  ASSERT_TRUE(client.waitFor([&] { return subscriber.getNumPublishers() > 0; }));
  sensor_msgs::LaserScan scan = client.nextScan();
  scan.ranges.assign(scan.ranges.size(), 2.0F);
  ASSERT_TRUE(client.project(scan));
  ASSERT_TRUE(client.waitFor([&] { return !view.ranges.empty(); }));
  EXPECT_EQ(view.header.frame_id, "view_stabilized");
  EXPECT_EQ(view.header.stamp, scan.header.stamp);
  const auto bins = static_cast<double>(view.ranges.size());
  EXPECT_NEAR(view.ranges[static_cast<std::size_t>(0.5 * bins)], 2.0F, 1e-4F);
  EXPECT_TRUE(std::isnan(view.ranges[0])) << "the laser has no beams behind the vehicle";
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "projector_flight_test");
  return RUN_ALL_TESTS();
}
