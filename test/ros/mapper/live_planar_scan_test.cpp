// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kestrel_slam/messages/planar_scan_message.h"
#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kLimit_m = 0.05;
constexpr std::uint32_t kQueue = 100;
constexpr char kFrame[] = "base_stabilized";  // its transform is never published

PlanarScan planarOf(const LaserScan& scan) {
  PlanarScan planar;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!std::isfinite(scan.ranges[i])) continue;
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    planar.rays.push_back(
        {Eigen::Vector2f::Zero(), scan.ranges[i] * direction.cast<float>(), true});
  }
  return planar;
}

/// Sends planar scans to a mapper that subscribes to `topic`. No transform of their frame is
/// published.
class PlanarClient {
 public:
  PlanarClient(const std::string& ns, const std::string& topic)
      : client(ns), publisher_(client.nh.advertise<kestrel_slam::PlanarScan>(topic, kQueue)) {}

  bool connect() {
    return client.waitFor(
        [this] {
          return publisher_.getNumSubscribers() > 0 && client.hearsPoses() &&
                 client.sharesTransforms();
        },
        10.0);
  }

  kestrel_slam::PlanarScanPtr messageOf(std::size_t i) const {
    const LaserScan& scan = flight.scans.at(i).scan;
    return toPlanarScanMessage(planarOf(scan), kFrame, ros::Time(scan.stamp));
  }

  void publish(const kestrel_slam::PlanarScan& message) { publisher_.publish(message); }

  std::optional<Pose2> match(const kestrel_slam::PlanarScan& message) {
    publish(message);
    const auto matched = [&] { return client.pose.header.stamp == message.header.stamp; };
    if (!client.waitFor(matched)) return std::nullopt;
    return poseOf(client.pose.pose);
  }

  MapperClient client;
  TestFlight flight = laboratoryFlight(200);

 private:
  ros::Publisher publisher_;
};

class LivePlanarScan : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    planar_ = new PlanarClient("", "planar_scan");
    ASSERT_TRUE(planar_->connect()) << "the mapper does not subscribe to planar_scan";
    for (int i = 0; i < 100; ++i) flyOn();
  }
  static void TearDownTestSuite() { delete planar_; }

  static void flyOn() {
    const std::size_t i = next_++;
    const auto pose = planar_->match(*planar_->messageOf(i));
    ASSERT_TRUE(pose) << "no pose for scan " << i;
    EXPECT_LT((planar_->flight.truth(i).inverse() * *pose).distance(), kLimit_m) << "scan " << i;
  }

  /// Publishes an invalid message. Expects that it is counted with its reason and has no other
  /// effect.
  static void expectDropped(const kestrel_slam::PlanarScan& message, const std::string& reason) {
    const std::string key = "dropped: " + reason;
    MapperClient& client = planar_->client;
    const std::string before = client.diagnosis("Scans", key);
    const std::size_t poses = client.poses_received;
    planar_->publish(message);
    const std::string expected = std::to_string(before.empty() ? 1 : std::stoi(before) + 1);
    EXPECT_TRUE(client.waitFor([&] { return client.diagnosis("Scans", key) == expected; }))
        << reason;
    EXPECT_EQ(client.poses_received, poses);
    flyOn();
  }

  inline static PlanarClient* planar_ = nullptr;
  inline static std::size_t next_ = 0;
};

TEST_F(LivePlanarScan, NeedsNoTransformOfTheLaser) {
  MapperClient& client = planar_->client;
  EXPECT_EQ(client.diagnosis("Scans", "topic"), "/planar_scan");
  EXPECT_EQ(client.diagnosis("Scans", "received"), client.diagnosis("Scans", "used"));
  EXPECT_GT(planar_->flight.truth(next_ - 1).distance(), 1.0) << "the vehicle must move";
  EXPECT_EQ(client.parents["base_footprint"], std::set<std::string>{"map"});
  EXPECT_TRUE(poseOf(client.lastTransform("base_footprint").transform) == poseOf(client.pose.pose));
}

TEST_F(LivePlanarScan, AShortArrayIsCounted) {
  auto message = planar_->messageOf(next_);
  message->end_x.resize(message->end_x.size() / 2);
  expectDropped(*message, "bad-planar-scan");
}

TEST_F(LivePlanarScan, NanIsCounted) {
  auto message = planar_->messageOf(next_);
  message->end_y[0] = kNan;
  expectDropped(*message, "bad-planar-scan");
}

TEST_F(LivePlanarScan, NoPointsAreCounted) {
  const auto message = toPlanarScanMessage(PlanarScan(), kFrame, ros::Time(1.0));
  message->header.stamp = planar_->messageOf(next_)->header.stamp;
  expectDropped(*message, "no-beams");
}

TEST_F(LivePlanarScan, TooManyPointsAreCounted) {
  auto message = planar_->messageOf(next_);
  constexpr std::size_t kTooMany = 1000000;
  for (auto* array : {&message->origin_x, &message->origin_y, &message->end_x, &message->end_y}) {
    array->resize(kTooMany);
  }
  message->hit.resize(kTooMany);
  expectDropped(*message, "too-many-beams");
}

TEST_F(LivePlanarScan, NoStampIsCounted) {
  auto message = planar_->messageOf(next_);
  message->header.stamp = ros::Time();
  expectDropped(*message, "bad-stamp");
}

TEST_F(LivePlanarScan, SeveralLasersMayHaveTheSameStamps) {
  const auto message = planar_->messageOf(next_);
  flyOn();
  const std::size_t poses = planar_->client.poses_received;
  planar_->publish(*message);
  EXPECT_TRUE(planar_->client.waitFor([&] { return planar_->client.poses_received == poses + 1; }));
  flyOn();
}

/// The only transform is odom -> base from the odometry, and it arrives late.
TEST(LivePlanarScanWithOdometry, WaitsForTheOdometryOfTheBase) {
  PlanarClient planar("odometry", "slice");
  MapperClient& client = planar.client;
  ASSERT_TRUE(planar.connect()) << "the mapper does not subscribe to slice";
  const Pose2 odom_T_start(3.0, -1.0, 0.5);
  for (std::size_t i = 0; i < 50; ++i) {
    const auto message = planar.messageOf(i);
    const std::size_t poses = client.poses_received;
    planar.publish(*message);
    if (i == 0) {
      EXPECT_FALSE(client.waitFor([&] { return client.poses_received > poses; }, 0.3))
          << "there is no odometry yet";
    }
    client.broadcaster.sendTransform(transformOf("odometry_odom", "odometry_base",
                                                 odom_T_start * planar.flight.truth(i),
                                                 message->header.stamp));
    ASSERT_TRUE(client.waitFor([&] { return client.poses_received > poses; })) << "scan " << i;
  }
  const Pose2 error = planar.flight.truth(49).inverse() * poseOf(client.pose.pose);
  EXPECT_LT(error.distance(), kLimit_m);
  const Pose2 map_T_odom = poseOf(client.lastTransform("odometry_odom").transform);
  EXPECT_LT((map_T_odom * odom_T_start).distance(), kLimit_m);
  EXPECT_EQ(client.parents["odometry_odom"], std::set<std::string>{"map"});
  EXPECT_EQ(client.parents["odometry_base"], std::set<std::string>{"odometry_odom"});
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_planar_scan_test");
  return RUN_ALL_TESTS();
}
