// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>
#include <limits>
#include <memory>

#include "projector_client.h"

namespace kestrel {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kImuPeriod = 0.005;  // s
constexpr double kDegree = 3.14159265358979 / 180.0;

/// Sends all kinds of invalid input to one running node. The diagnostics must contain the reason
/// for each input, and valid input after it must be projected immediately. The tests depend on each
/// other.
class ProjectorGarbage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = std::make_unique<ProjectorClient>("garbage");
    client_->height_publisher = client_->nh.advertise<sensor_msgs::Range>("height", 10);
    ASSERT_TRUE(client_->connect());
  }
  static void TearDownTestSuite() { client_.reset(); }

  static std::size_t droppedFor(const std::string& reason) {
    const std::string count = client_->diagnosis("Scans", "dropped: " + reason);
    return count.empty() ? 0 : std::stoul(count);
  }

  /// Runs `publish`, and expects that `count` scans are dropped for `reason`.
  template <typename Publish>
  static void expectDropped(const std::string& reason, std::size_t count, const Publish& publish) {
    const std::size_t before = droppedFor(reason), projected = client_->planar_scans.size();
    publish();
    EXPECT_TRUE(client_->waitFor([&] { return droppedFor(reason) >= before + count; }))
        << reason << " in: " << client_->report("Scans")["message"];
    EXPECT_EQ(droppedFor(reason), before + count);
    EXPECT_EQ(client_->planar_scans.size(), projected);
  }
  static void expectDropped(const std::string& reason, const sensor_msgs::LaserScan& scan) {
    expectDropped(reason, 1, [&] { client_->scan_publisher.publish(scan); });
  }
  static void expectCloudDropped(const sensor_msgs::PointCloud2& cloud, const std::string& text) {
    expectDropped("bad-cloud", 1, [&] { client_->cloud_publisher.publish(cloud); });
    client_->cloud_publisher.publish(later(cloud));
    EXPECT_TRUE(client_->waitFor([&] {
      return client_->report("Scans")["message"].find(text) != std::string::npos;
    })) << text;
    client_->flyOn();
  }
  static sensor_msgs::PointCloud2 later(sensor_msgs::PointCloud2 cloud) {
    cloud.header.stamp += ros::Duration(0.01);
    return cloud;
  }

  static void expectAttitude(const std::string& health, const std::string& text) {
    auto report = client_->report("Attitude");
    EXPECT_EQ(report["health"], health) << report["message"];
    EXPECT_EQ(report["level"], health == "ok" ? "0" : "2") << report["message"];
    EXPECT_NE(report["message"].find(text), std::string::npos) << report["message"];
  }

  /// Publishes valid IMU data and a few valid scans. After that, no error may remain.
  static void recover() {
    client_->skip(0.1);
    for (int i = 0; i < 5; ++i) client_->flyOn();
    expectAttitude("ok", "ok");
  }

  /// Publishes IMU messages for one second, each changed by `spoil`. The flight time advances.
  template <typename Spoil>
  static void flyBadImu(const Spoil& spoil) {
    for (int i = 0; i < 200; ++i) {
      sensor_msgs::Imu message = client_->flight.imu(client_->imu_time, "garbage_imu");
      spoil(message);
      client_->imu_publisher.publish(message);
      client_->imu_time += kImuPeriod;
    }
    client_->time = client_->imu_time - 0.05;
  }

  /// Three points in front of the vehicle.
  static sensor_msgs::PointCloud2 cloud() {
    sensor_msgs::PointCloud2 message;
    message.header.frame_id = "garbage_base";
    message.header.stamp = ros::Time(client_->time);
    sensor_msgs::PointCloud2Modifier modifier(message);
    modifier.setPointCloud2FieldsByString(1, "xyz");
    modifier.resize(3);
    sensor_msgs::PointCloud2Iterator<float> x(message, "x"), y(message, "y"), z(message, "z");
    for (int i = 0; i < 3; ++i, ++x, ++y, ++z) {
      *x = 2.0F;
      *y = static_cast<float>(i - 1);
      *z = 0.0F;
    }
    return message;
  }
  static void expectHits(const sensor_msgs::PointCloud2& message, std::size_t hits) {
    client_->flyImu(message.header.stamp.toSec() + 0.05);
    client_->cloud_publisher.publish(message);
    const auto& scans = client_->planar_scans;
    ASSERT_TRUE(client_->waitFor([&] { return scans.count(message.header.stamp) > 0; }));
    EXPECT_EQ(client_->diagnosis("Scans", "beams: hits"), std::to_string(hits));
  }

  static std::unique_ptr<ProjectorClient> client_;
};
std::unique_ptr<ProjectorClient> ProjectorGarbage::client_;

// The first tests add the inputs that a projector needs, one after the other.
TEST_F(ProjectorGarbage, A0_NoTransformOfTheLaser) {
  expectDropped("no-transform", client_->nextScan());
  auto report = client_->report("Scans");
  EXPECT_EQ(report["level"], "2");
  for (const char* text : {"'garbage_laser'", "'garbage_base'", "static_transform_publisher"}) {
    EXPECT_NE(report["message"].find(text), std::string::npos) << report["message"];
  }
  client_->mount("laser", client_->base_T_laser);
  client_->wait(0.3);
}

TEST_F(ProjectorGarbage, A1_LaserBeforeImu) {
  expectDropped("no-imu", client_->nextScan());
  auto report = client_->report("Attitude");
  EXPECT_EQ(report["level"], "2");
  for (const char* text : {"no message on /garbage/imu/data", "~attitude_source to none"}) {
    EXPECT_NE(report["message"].find(text), std::string::npos) << report["message"];
  }
}

TEST_F(ProjectorGarbage, A2_NoTransformOfTheImu) {
  expectDropped("imu-no-transform", 1, [] {
    client_->flyImu(client_->time + 0.1);
    client_->wait(0.3);
    client_->scan_publisher.publish(client_->nextScan());
  });
  EXPECT_NE(client_->report("Attitude")["message"].find("IMU's frame 'garbage_imu'"),
            std::string::npos);
  client_->mount("imu", Eigen::Isometry3d::Identity());
  client_->wait(0.3);
  recover();
  EXPECT_EQ(client_->report("Scans")["level"], "0");
}

TEST_F(ProjectorGarbage, ImuSilent) {
  client_->wait(4.5);
  client_->skip(4.5);
  expectDropped("imu-silent", client_->nextScan());
  expectAttitude("silent", "");
  recover();
}

TEST_F(ProjectorGarbage, ImuFrozen) {
  const sensor_msgs::Imu stuck = client_->flight.imu(client_->imu_time, "garbage_imu");
  flyBadImu([&](sensor_msgs::Imu& message) {
    const ros::Time stamp = message.header.stamp;
    message = stuck;
    message.header.stamp = stamp;
  });
  expectDropped("imu-frozen", client_->nextScan());
  expectAttitude("frozen", "");
  recover();
}

TEST_F(ProjectorGarbage, ImuNotFinite) {
  flyBadImu([](sensor_msgs::Imu& message) {
    message.orientation.x = kNan;
    message.angular_velocity.z = kNan;
  });
  expectDropped("imu-invalid", client_->nextScan());
  expectAttitude("invalid", "");
  recover();
}

TEST_F(ProjectorGarbage, ImuQuaternionIsNoRotation) {
  flyBadImu([](sensor_msgs::Imu& message) { message.orientation.w += 2.0; });
  expectDropped("imu-invalid", client_->nextScan());
  expectAttitude("invalid", "");
  recover();
}

TEST_F(ProjectorGarbage, ImuUpsideDown) {
  flyBadImu([](sensor_msgs::Imu& message) {
    const auto& q = message.orientation;  // additional rotation by 180 degrees about x
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(q.w, q.x, q.y, q.z) * Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
    message.orientation.w = turned.w();
    message.orientation.x = turned.x();
    message.orientation.y = turned.y();
    message.orientation.z = turned.z();
    message.linear_acceleration.y *= -1.0;
    message.linear_acceleration.z *= -1.0;
  });
  expectDropped("tilted", client_->nextScan());
  expectAttitude("upside-down", "");
  recover();
}

TEST_F(ProjectorGarbage, ImuStampsGoBack) {
  client_->imu_publisher.publish(client_->flight.imu(client_->imu_time - 0.0125, "garbage_imu"));
  for (int i = 0; i < 3; ++i) client_->flyOn();  // a late message has no effect
  client_->time -= 60.0;                         // the clock is set back
  client_->imu_time = client_->time - 0.2;
  client_->flyImu(client_->time);
  client_->wait(0.2);
  recover();
}

TEST_F(ProjectorGarbage, TiltedBeyondTheLimitForSeconds) {
  const TiltingFlight good = client_->flight;
  client_->flight.roll_amplitude = client_->flight.pitch_amplitude = 50.0 * kDegree;
  client_->skip(0.1);
  expectDropped("tilted", 80, [] {
    for (int i = 0; i < 80; ++i) {
      client_->imu_time = std::max(client_->imu_time, client_->time - 0.05);
      client_->flyImu(client_->time + 0.03);
      client_->scan_publisher.publish(client_->nextScan());
      client_->wait(0.002);
    }
  });
  client_->scan_publisher.publish(client_->nextScan());
  client_->flyImu(client_->time + 0.03);
  EXPECT_TRUE(client_->waitFor([&] {
    return client_->report("Scans")["message"].find("max_tilt allows") != std::string::npos;
  }));
  client_->flight = good;
  recover();
}

TEST_F(ProjectorGarbage, HeightIsInfinite) {
  sensor_msgs::Range message;
  message.header.frame_id = "garbage_base";
  message.min_range = 0.1F;
  message.max_range = 10.0F;
  for (const float height : {std::numeric_limits<float>::infinity(), static_cast<float>(kNan)}) {
    message.range = height;
    message.header.stamp = ros::Time(client_->time);
    client_->height_publisher.publish(message);
    client_->flyOn();
  }
  auto report = client_->report("Height");
  EXPECT_EQ(report.count("height (m)"), 0U);
  EXPECT_EQ(report["infinite"], "1");
  EXPECT_EQ(report["not finite"], "1");
  EXPECT_NE(report["message"].find("must be a finite distance"), std::string::npos)
      << report["message"];
  message.range = 1.25F;
  message.header.stamp = ros::Time(client_->time);
  client_->height_publisher.publish(message);
  client_->wait(0.1);
  EXPECT_NE(client_->diagnosis("Height", "height (m)"), "");
}

TEST_F(ProjectorGarbage, CloudWithoutTheFieldsNeeded) {
  sensor_msgs::PointCloud2 message = cloud();
  message.fields[2].name = "intensity";
  expectCloudDropped(message, "intensity");
}

TEST_F(ProjectorGarbage, CloudWithoutPoints) {
  sensor_msgs::PointCloud2 message = cloud();
  message.width = message.row_step = 0;
  message.data.clear();
  expectCloudDropped(message, "zero points");
}

TEST_F(ProjectorGarbage, CloudShorterThanPromised) {
  sensor_msgs::PointCloud2 message = cloud();
  message.data.resize(10);
  expectCloudDropped(message, "10");
}

TEST_F(ProjectorGarbage, CloudBigEndian) {
  sensor_msgs::PointCloud2 message = cloud();
  for (std::size_t i = 0; i + 4 <= message.data.size(); i += 4) {
    std::reverse(message.data.begin() + static_cast<long>(i),
                 message.data.begin() + static_cast<long>(i + 4));
  }
  message.is_bigendian = 1;
  expectHits(message, 3);
  recover();
}

TEST_F(ProjectorGarbage, CloudOrganizedWithNan) {
  sensor_msgs::PointCloud2 message = cloud();
  std::swap(message.width, message.height);
  message.row_step = message.point_step;
  *sensor_msgs::PointCloud2Iterator<float>(message, "x") = static_cast<float>(kNan);
  message.is_dense = 0;
  expectHits(message, 2);
  recover();
}

TEST_F(ProjectorGarbage, ScansOfEveryKind) {
  client_->flyImu(client_->time + 0.2);
  sensor_msgs::LaserScan scan = client_->nextScan();
  scan.ranges.clear();
  expectDropped("no-beams", scan);
  scan = client_->nextScan();
  scan.header.frame_id.clear();
  expectDropped("no-frame", scan);
  scan = client_->nextScan();
  scan.header.stamp = ros::Time();
  expectDropped("bad-stamp", scan);
  scan = client_->nextScan();
  scan.ranges.assign(scan.ranges.size(), 4000.0F);  // in mm
  scan.ranges.front() = 4001.0F;
  expectDropped("wrong-unit", scan);
  scan = client_->nextScan();
  scan.ranges.assign(1000000, 1.0F);
  expectDropped("too-many-beams", scan);
  scan = client_->nextScan();
  scan.ranges.assign(scan.ranges.size(), static_cast<float>(kNan));
  expectDropped("no-valid-beam", scan);
  recover();
}

TEST_F(ProjectorGarbage, StampsOfAnotherClock) {
  sensor_msgs::LaserScan scan = client_->nextScan();
  scan.header.stamp += ros::Duration(3600.0);
  client_->flyImu(client_->time);
  client_->scan_publisher.publish(scan);
  EXPECT_TRUE(client_->waitFor([&] {
    return client_->report("Scans")["message"].find("from the same clock?") != std::string::npos;
  })) << client_->report("Scans")["message"];
  recover();
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "projector_garbage_test");
  return RUN_ALL_TESTS();
}
