// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_flight_writer.h"

#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseArray.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/Range.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "simulation/test_flight.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kSeed = 4;
constexpr double kStampRounding = 1e-6;  // s

class BagFlightWriter : public testing::Test {
 protected:
  FlightBagSummary write(const VehicleModel& vehicle, const std::string& name = "flight.bag") {
    FlightSimulator flight(world_, motion_, vehicle, kSeed);
    return writeFlightBag(folder_.file(name), flight, vehicle);
  }

  /// The messages of a topic; the test fails if there are none.
  template <typename Message>
  std::vector<Message> read(const std::string& topic, const std::string& name = "flight.bag") {
    rosbag::Bag bag(folder_.file(name), rosbag::bagmode::Read);
    std::vector<Message> messages;
    for (const rosbag::MessageInstance& instance : rosbag::View(bag, rosbag::TopicQuery(topic))) {
      const auto message = instance.instantiate<Message>();
      if (message) messages.push_back(*message);
    }
    EXPECT_FALSE(messages.empty()) << topic;
    return messages;
  }

  std::string bytes(const std::string& name) const {
    std::ifstream file(folder_.file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  const World world_ = World(roomWithWalker());
  const KnownMotion motion_ = KnownMotion(2.0);
  const TemporaryFolder folder_;
};

TEST_F(BagFlightWriter, WritesTheScansOfTheSimulator) {
  const FlightBagSummary summary = write(smallVehicle());
  const auto expected = messagesOf<LaserScan>(simulateAll(world_, motion_, smallVehicle(), kSeed));
  const auto scans = read<sensor_msgs::LaserScan>("/scan");
  ASSERT_EQ(scans.size(), expected.size());
  ASSERT_EQ(summary.scan_stamps.size(), expected.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_NEAR(scans[i].header.stamp.toSec(), expected[i].stamp, kStampRounding);
    EXPECT_EQ(summary.scan_stamps[i], expected[i].stamp);
    EXPECT_EQ(scans[i].header.frame_id, "laser");
    EXPECT_EQ(scans[i].ranges, expected[i].ranges);
  }
  EXPECT_NEAR(scans[0].angle_min, -1.5, 1e-6);
  EXPECT_NEAR(scans[0].angle_max, 1.5, 1e-6);
  EXPECT_NEAR(scans[0].time_increment, 1e-4, 1e-9);
  EXPECT_NEAR(scans[0].scan_time, 0.1, 1e-6);
}

TEST_F(BagFlightWriter, GroundTruthIsPoseInTheWorldAndTwistInTheBase) {
  write(smallVehicle());
  for (const auto& truth : read<nav_msgs::Odometry>("/ground_truth")) {
    EXPECT_EQ(truth.header.frame_id, "world");
    EXPECT_EQ(truth.child_frame_id, "base_link");
    const double t = truth.header.stamp.toSec() - kFlightStart;
    const geometry_msgs::Pose& pose = truth.pose.pose;
    EXPECT_NEAR(pose.position.x, 2.0 * std::sin(t), 1e-5);
    EXPECT_NEAR(pose.position.z, 1.0 + 0.1 * std::sin(t), 1e-5);
    EXPECT_NEAR(2.0 * std::atan2(pose.orientation.z, pose.orientation.w), 0.5 * t, 1e-5);
    const geometry_msgs::Twist& twist = truth.twist.twist;
    EXPECT_NEAR(twist.linear.x, 2.0 * std::cos(t) * std::cos(0.5 * t), 1e-5);
    EXPECT_NEAR(twist.linear.y, -2.0 * std::cos(t) * std::sin(0.5 * t), 1e-5);
    EXPECT_NEAR(twist.linear.z, 0.1 * std::cos(t), 1e-5);
    EXPECT_NEAR(twist.angular.z, 0.5, 1e-9);
  }
}

TEST_F(BagFlightWriter, ImuMessageMarksMissingOrientation) {
  VehicleModel vehicle = onlyImu(ImuModel());
  write(vehicle);
  const auto expected = messagesOf<ImuSample>(simulateAll(world_, motion_, vehicle, kSeed));
  const auto full = read<sensor_msgs::Imu>("/imu/data");
  ASSERT_EQ(full.size(), expected.size());
  EXPECT_EQ(full[7].header.frame_id, "imu_link");
  EXPECT_EQ(full[7].orientation.z, expected[7].world_R_imu->z());
  EXPECT_EQ(full[7].angular_velocity.x, expected[7].angular_velocity->x());
  EXPECT_EQ(full[7].linear_acceleration.z, expected[7].linear_acceleration->z());
  EXPECT_DOUBLE_EQ(full[7].orientation_covariance[0], 0.005 * 0.005);
  EXPECT_DOUBLE_EQ(full[7].orientation_covariance[8], 0.05 * 0.05);
  EXPECT_DOUBLE_EQ(full[7].angular_velocity_covariance[4], 0.0009 * 0.0009 * 100.0);
  EXPECT_EQ(full[7].angular_velocity_covariance[1], 0.0);

  vehicle.imu->gives_orientation = false;
  write(vehicle, "raw.bag");
  const auto raw = read<sensor_msgs::Imu>("/imu/data", "raw.bag");
  EXPECT_EQ(raw[7].orientation_covariance[0], -1.0);
  EXPECT_EQ(raw[7].angular_velocity.x, expected[7].angular_velocity->x());
}

TEST_F(BagFlightWriter, WritesHeightsAndPeople) {
  write(smallVehicle());
  const auto events = simulateAll(world_, motion_, smallVehicle(), kSeed);
  const auto range = read<sensor_msgs::Range>("/height").at(5);
  EXPECT_EQ(range.header.frame_id, "range_finder");
  EXPECT_EQ(range.range, static_cast<float>(messagesOf<HeightSample>(events)[5].height_m));
  EXPECT_EQ(range.max_range, 6.0F);
  const auto pressure = read<geometry_msgs::PointStamped>("/pressure_height").at(5);
  EXPECT_EQ(pressure.header.frame_id, "world");
  EXPECT_EQ(pressure.point.z, messagesOf<Barometer>(events)[5].sample.height_m);
  const auto people = read<geometry_msgs::PoseArray>("/people").at(5);
  ASSERT_EQ(people.poses.size(), 1U);
  EXPECT_EQ(people.header.frame_id, "world");
  EXPECT_NEAR(people.poses[0].position.x, world_.parts().walkers[0].at(0.5).x(), 1e-6);
}

TEST_F(BagFlightWriter, CloudsHaveTheFieldsOfAVelodyneDriver) {
  write(smallVehicle());
  const auto clouds = read<sensor_msgs::PointCloud2>("/points");
  const auto expected = messagesOf<PointCloud>(simulateAll(world_, motion_, smallVehicle(), kSeed));
  ASSERT_EQ(clouds.size(), expected.size());
  const sensor_msgs::PointCloud2& cloud = clouds[3];
  EXPECT_EQ(cloud.header.frame_id, "velodyne");
  std::string fields;
  for (const sensor_msgs::PointField& field : cloud.fields) fields += field.name + " ";
  EXPECT_EQ(fields, "x y z intensity ring time ");
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"), z(cloud, "z"), time(cloud, "time");
  sensor_msgs::PointCloud2ConstIterator<std::uint16_t> ring(cloud, "ring");
  std::vector<std::size_t> of_ring(3);
  std::size_t i = 0;
  for (const PointCloud::Point& point : expected[3].points) {
    if (std::isnan(point.x)) continue;
    ASSERT_NE(x, x.end());
    EXPECT_EQ(x[0], point.x);
    EXPECT_EQ(*z, point.z);
    EXPECT_EQ(*time, point.time);
    EXPECT_EQ(*ring, point.z < -0.05 ? 0 : point.z > 0.05 ? 2 : 1);  // elevations -0.2, 0, 0.2
    ++of_ring.at(*ring);
    ++x, ++z, ++time, ++ring, ++i;
  }
  EXPECT_EQ(static_cast<std::size_t>(cloud.width) * cloud.height, i);
  EXPECT_GT(*std::min_element(of_ring.begin(), of_ring.end()), 0U);
}

TEST_F(BagFlightWriter, StaticTransformsAreLatchedAndComplete) {
  VehicleModel vehicle = smallVehicle();
  vehicle.base_T_laser.translation() = Eigen::Vector3d(0.08, 0.0, 0.06);
  vehicle.base_R_imu = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX());
  write(vehicle);
  rosbag::Bag bag(folder_.file("flight.bag"), rosbag::bagmode::Read);
  rosbag::View view(bag, rosbag::TopicQuery("/tf_static"));
  ASSERT_EQ(view.size(), 1U);
  const auto message = view.begin()->instantiate<tf2_msgs::TFMessage>();
  std::map<std::string, geometry_msgs::Transform> mountings;
  for (const geometry_msgs::TransformStamped& transform : message->transforms) {
    EXPECT_EQ(transform.header.frame_id, "base_link");
    mountings[transform.child_frame_id] = transform.transform;
  }
  ASSERT_EQ(mountings.size(), 4U);
  EXPECT_EQ(mountings.at("laser").translation.z, 0.06);
  EXPECT_NEAR(std::abs(mountings.at("imu_link").rotation.x), 1.0, 1e-12);
  EXPECT_EQ(mountings.at("velodyne").rotation.w, 1.0);
  EXPECT_NEAR(mountings.at("range_finder").rotation.y, std::sqrt(0.5),
              1e-12);  // the x axis points down
  // The Python bag reader rejects a connection without these fields.
  const rosbag::ConnectionInfo& connection = *view.getConnections().at(0);
  for (const char* field : {"type", "md5sum", "message_definition"}) {
    EXPECT_EQ(connection.header->count(field), 1U) << field;
  }
  EXPECT_EQ(connection.header->at("latching"), "1");
}

TEST_F(BagFlightWriter, MessagesAreRecordedAtTheirArrival) {
  VehicleModel vehicle = smallVehicle();
  vehicle.stamp_jitter_s = 0.01;
  const FlightBagSummary summary = write(vehicle);
  const auto events = simulateAll(world_, motion_, vehicle, kSeed);
  rosbag::Bag bag(folder_.file("flight.bag"), rosbag::bagmode::Read);
  rosbag::View view(bag);
  EXPECT_EQ(view.getBeginTime(), ros::Time(kFlightStart));
  EXPECT_EQ(view.size(), events.size() + 1);  // one more: the static transforms
  EXPECT_EQ(summary.messages, view.size());
  std::multimap<std::uint64_t, std::size_t> expected;
  for (std::size_t i = 0; i < events.size(); ++i) {
    expected.emplace(ros::Time(events[i].arrival).toNSec(), events[i].message.index());
  }
  auto next = expected.begin();
  for (const rosbag::MessageInstance& message : view) {
    if (message.getTopic() == "/tf_static") continue;
    ASSERT_EQ(message.getTime().toNSec(), (next++)->first);
  }
}

TEST_F(BagFlightWriter, MissingSensorHasNoTopicAndNoFrame) {
  write(onlyImu(ImuModel()));
  rosbag::Bag bag(folder_.file("flight.bag"), rosbag::bagmode::Read);
  std::set<std::string> topics;
  for (const auto* connection : rosbag::View(bag).getConnections()) {
    topics.insert(connection->topic);
  }
  EXPECT_EQ(topics, (std::set<std::string>{"/imu/data", "/people", "/tf_static"}));
  EXPECT_EQ(read<tf2_msgs::TFMessage>("/tf_static")[0].transforms.size(), 1U);
}

TEST_F(BagFlightWriter, SameSeedGivesTheSameBytes) {
  VehicleModel vehicle = smallVehicle();
  vehicle.stamp_jitter_s = 0.001;
  vehicle.loss_probability = 0.1;
  write(vehicle, "a.bag");
  write(vehicle, "b.bag");
  ASSERT_GT(bytes("a.bag").size(), 100000U);
  EXPECT_TRUE(bytes("a.bag") == bytes("b.bag"));
  FlightSimulator other(world_, motion_, vehicle, kSeed + 1);
  writeFlightBag(folder_.file("c.bag"), other, vehicle);
  EXPECT_FALSE(bytes("a.bag") == bytes("c.bag"));
}

TEST_F(BagFlightWriter, FailureNamesTheFileAndLeavesNoFile) {
  const std::string missing = folder_.file("no_such_folder/flight.bag");
  FlightSimulator flight(world_, motion_, smallVehicle(), kSeed);
  const auto writeTo = [&](const std::string& path) {
    return messageOf([&] { writeFlightBag(path, flight, smallVehicle()); });
  };
  EXPECT_CONTAINS(writeTo(missing), missing);
  std::filesystem::create_directory(folder_.file("folder"));
  EXPECT_CONTAINS(writeTo(folder_.file("folder")), "choose another name");
  EXPECT_FALSE(std::filesystem::exists(folder_.file("folder.part")));
}

}  // namespace
}  // namespace kestrel
