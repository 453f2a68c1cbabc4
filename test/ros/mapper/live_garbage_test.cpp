// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr double kLimit_m = 0.05;

/// Sends invalid scans to a running node. After each of them, valid scans must still give correct
/// poses.
class LiveGarbage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new MapperClient;
    flight_ = new TestFlight(laboratoryFlight(400));
    ASSERT_TRUE(client_->connect()) << "the mapper does not subscribe to scan";
    for (int i = 0; i < 20; ++i) flyOn();
  }
  static void TearDownTestSuite() {
    delete client_;
    delete flight_;
  }

  static sensor_msgs::LaserScan nextMessage() {
    return messageOf(flight_->scans.at(next_++).scan, "base_link", shift_s_);
  }

  static void flyOn() {
    const std::size_t i = next_;
    const auto pose = client_->match(nextMessage());
    ASSERT_TRUE(pose) << "no pose for scan " << i;
    EXPECT_LT((flight_->truth(i).inverse() * *pose).distance(), kLimit_m) << "scan " << i;
  }

  /// Publishes an invalid scan. Expects that it is counted with its reason and has no other effect.
  static void expectDropped(const sensor_msgs::LaserScan& scan, const std::string& reason) {
    const std::string key = "dropped: " + reason;
    const std::string before = client_->diagnosis("Scans", key);
    const std::size_t poses = client_->poses_received;
    client_->publish(scan);
    const std::string expected = std::to_string(before.empty() ? 1 : std::stoi(before) + 1);
    EXPECT_TRUE(client_->waitFor([&] { return client_->diagnosis("Scans", key) == expected; }))
        << reason;
    EXPECT_EQ(client_->poses_received, poses);
    flyOn();
  }

  inline static MapperClient* client_ = nullptr;
  inline static TestFlight* flight_ = nullptr;
  inline static std::size_t next_ = 0;
  inline static double shift_s_ = 0.0;
};

TEST_F(LiveGarbage, OnlyNan) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.ranges.assign(scan.ranges.size(), kNan);
  expectDropped(scan, "no-valid-beam");
}

TEST_F(LiveGarbage, NoBeams) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.ranges.clear();
  expectDropped(scan, "no-beams");
}

TEST_F(LiveGarbage, NoIncrement) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.angle_increment = 0.0F;
  expectDropped(scan, "bad-geometry");
}

TEST_F(LiveGarbage, TenMillionBeams) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.ranges.assign(10000000, 1.0F);
  expectDropped(scan, "too-many-beams");
}

TEST_F(LiveGarbage, NoFrame) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.header.frame_id.clear();
  expectDropped(scan, "no-frame");
}

TEST_F(LiveGarbage, NoStamp) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.header.stamp = ros::Time();
  expectDropped(scan, "bad-stamp");
}

TEST_F(LiveGarbage, RepeatedStamp) {
  sensor_msgs::LaserScan scan = nextMessage();
  scan.header.stamp = client_->pose.header.stamp;
  expectDropped(scan, "repeated-stamp");
}

TEST_F(LiveGarbage, NumberOfBeamsChanges) {
  sensor_msgs::LaserScan scan = nextMessage();
  std::vector<float> every_second;
  for (std::size_t i = 0; i < scan.ranges.size(); i += 2) every_second.push_back(scan.ranges[i]);
  scan.ranges = every_second;
  scan.angle_increment *= 2.0F;
  const auto pose = client_->match(scan);
  ASSERT_TRUE(pose);
  EXPECT_LT((flight_->truth(next_ - 1).inverse() * *pose).distance(), kLimit_m);
  flyOn();
}

TEST_F(LiveGarbage, RandomScansGiveFinitePoses) {
  std::mt19937 random(1);
  const float values[] = {kNan, kInf, -kInf, 0.0F, -1.0F, 1e30F, 1e-30F};
  for (int n = 0; n < 50; ++n) {
    sensor_msgs::LaserScan scan =
        messageOf(flight_->scans[next_].scan, "base_link", shift_s_ + 1e-4 * n - 0.05);
    for (float& range : scan.ranges) {
      if (random() % 2 == 0) range = values[random() % std::size(values)];
    }
    client_->publish(scan);
  }
  client_->waitFor([] { return false; }, 0.5);
  const Pose2 pose = poseOf(client_->pose.pose);  // throws if it is not finite
  EXPECT_TRUE(pose.isFinite());
  flyOn();
}

TEST_F(LiveGarbage, StampsGoBackALittle) {
  shift_s_ -= 0.5;  // five scans
  flyOn();
  shift_s_ += 0.5;
  flyOn();
}

TEST_F(LiveGarbage, StampsJumpAnHour) {
  shift_s_ += 3600.0;
  flyOn();
  flyOn();
}

// The last test: the recording starts again immediately, at the current pose of the vehicle.
TEST_F(LiveGarbage, StampsStartAgain) {
  shift_s_ -= 5000.0;
  flyOn();
  flyOn();
  EXPECT_EQ(client_->diagnosis("Match", "state"), "ok");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_garbage_test");
  return RUN_ALL_TESTS();
}
