// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_imu.h"

#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

sensor_msgs::Imu imuAt(double stamp) {
  sensor_msgs::Imu imu;
  imu.header.stamp = ros::Time(stamp);
  imu.header.frame_id = "imu_link";
  imu.orientation.x = 0.6;
  imu.orientation.w = 0.8;
  imu.angular_velocity.z = 0.25;
  imu.linear_acceleration.x = 0.5;
  imu.linear_acceleration.z = 9.75;
  return imu;
}

sensor_msgs::Range rangeAt(double stamp, float range, const std::string& frame = "sonar") {
  sensor_msgs::Range message;
  message.header.stamp = ros::Time(stamp);
  message.header.frame_id = frame;
  message.min_range = 0.125F;
  message.max_range = 4.0F;
  message.range = range;
  return message;
}

tf2_msgs::TFMessage mounting(const std::string& child, const Eigen::Quaterniond& rotation,
                             double z = 0.0) {
  geometry_msgs::TransformStamped t;
  t.header.stamp = ros::Time(1.0);
  t.header.frame_id = "base_link";
  t.child_frame_id = child;
  t.transform.translation.z = z;
  t.transform.rotation.x = rotation.x();
  t.transform.rotation.y = rotation.y();
  t.transform.rotation.z = rotation.z();
  t.transform.rotation.w = rotation.w();
  tf2_msgs::TFMessage message;
  message.transforms.push_back(t);
  return message;
}

Eigen::Quaterniond turn(double degrees, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degToRad(degrees), axis));
}

const Eigen::Quaterniond kDown = turn(90.0, Eigen::Vector3d::UnitY());  // x axis points down

class BagImuTest : public ::testing::Test {
 protected:
  std::unique_ptr<Recording> read(const std::function<void(rosbag::Bag&)>& fill,
                                  const RecordingOptions& options = RecordingOptions()) {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    sensor_msgs::LaserScan scan;
    scan.header.stamp = ros::Time(2.0);
    scan.header.frame_id = "base_link";
    scan.ranges = {1.0F};
    bag.write("/scan", ros::Time(2.0), scan);
    bag.write("/tf_static", ros::Time(1.0), mounting("camera", Eigen::Quaterniond::Identity()));
    fill(bag);
    bag.close();
    return openRecording(path_, options);
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("a.bag");
};

TEST(ImuMessage, ValuesAreConverted) {
  const ImuSample sample = toImuSample(imuAt(2.5));
  EXPECT_EQ(sample.stamp, 2.5);
  ASSERT_TRUE(sample.world_R_imu && sample.angular_velocity && sample.linear_acceleration);
  EXPECT_EQ(sample.world_R_imu->coeffs(), Eigen::Vector4d(0.6, 0.0, 0.0, 0.8));
  EXPECT_EQ(*sample.angular_velocity, Eigen::Vector3d(0.0, 0.0, 0.25));
  EXPECT_EQ(*sample.linear_acceleration, Eigen::Vector3d(0.5, 0.0, 9.75));
}

TEST(ImuMessage, DataMissingInTheDriverAreAbsent) {
  sensor_msgs::Imu message = imuAt(1.0);
  message.orientation_covariance[0] = -1.0;
  EXPECT_FALSE(toImuSample(message).world_R_imu);
  EXPECT_TRUE(toImuSample(message).angular_velocity);
  message.angular_velocity_covariance[0] = -1.0;
  EXPECT_FALSE(toImuSample(message).angular_velocity);
  message.linear_acceleration_covariance[0] = -1.0;
  EXPECT_FALSE(toImuSample(message).linear_acceleration);
  message = imuAt(1.0);
  message.orientation = geometry_msgs::Quaternion();
  EXPECT_FALSE(toImuSample(message).world_R_imu);
}

TEST(ImuMessage, InvalidValuesArePassedOn) {
  sensor_msgs::Imu message = imuAt(1.0);
  message.orientation.x = std::nan("");
  message.angular_velocity.z = kInfinity;
  const ImuSample sample = toImuSample(message);
  EXPECT_TRUE(std::isnan(sample.world_R_imu->x()));
  EXPECT_EQ(sample.angular_velocity->z(), kInfinity);
}

TEST_F(BagImuTest, ReadsTheImuInTheOrderOfTheFileWithItsMounting) {
  const Eigen::Quaterniond upside_down = turn(180.0, Eigen::Vector3d::UnitX());
  const auto recording = read([&](rosbag::Bag& bag) {
    bag.write("/tf_static", ros::Time(1.0), mounting("imu_link", upside_down));
    bag.write("/imu", ros::Time(2.0), imuAt(2.25));
    bag.write("/imu", ros::Time(2.1), imuAt(2.0));   // earlier than the one before
    bag.write("/imu", ros::Time(2.2), imuAt(2.25));  // repeated
    bag.write("/imu", ros::Time(2.5), imuAt(0.0));   // without a stamp
  });
  const RecordedImu& imu = recording->imu();
  EXPECT_EQ(imu.topic, "/imu");
  EXPECT_NEAR(Eigen::Quaterniond(imu.base_T_imu.linear()).angularDistance(upside_down), 0.0, 1e-12);
  ASSERT_EQ(imu.samples.size(), 4U);
  EXPECT_EQ(imu.samples[0].stamp, 2.25);
  EXPECT_EQ(imu.samples[1].stamp, 2.0);
  EXPECT_EQ(imu.samples[2].stamp, 2.25);
  EXPECT_EQ(imu.samples[3].stamp, 2.5);
  EXPECT_TRUE(recording->warnings().empty());
  EXPECT_CONTAINS(recording->description(), ", IMU /imu");
}

TEST_F(BagImuTest, WithoutTfTheAxesAreThoseOfTheVehicleWithOneWarning) {
  const auto recording = read([](rosbag::Bag& bag) {
    for (int i = 1; i < 9; ++i) bag.write("/imu", ros::Time(i), imuAt(i));
  });
  EXPECT_EQ(recording->imu().samples.size(), 8U);
  EXPECT_EQ(recording->imu().base_T_imu.matrix(), Eigen::Matrix4d::Identity());
  ASSERT_EQ(recording->warnings().size(), 1U);
  EXPECT_CONTAINS(recording->warnings()[0], "no tf base_link -> imu_link: the IMU axes");
}

TEST_F(BagImuTest, UsesTheImuWithMostMessagesOrTheRequestedOne) {
  const auto fill = [](rosbag::Bag& bag) {
    bag.write("/tf_static", ros::Time(1.0), mounting("imu_link", Eigen::Quaterniond::Identity()));
    bag.write("/a/imu", ros::Time(1.0), imuAt(1.0));
    for (int i = 1; i < 4; ++i) bag.write("/b/imu", ros::Time(i), imuAt(i));
  };
  const auto busiest = read(fill);
  EXPECT_EQ(busiest->imu().topic, "/b/imu");
  EXPECT_CONTAINS(busiest->warnings().at(0), "the one with the most messages is used: /b/imu");
  RecordingOptions options;
  options.imu_topic = "a/imu";
  EXPECT_EQ(read(fill, options)->imu().samples.size(), 1U);
  options.imu_topic = "/c/imu";
  EXPECT_CONTAINS(messageOf([&] { read(fill, options); }),
                  "a.bag: no topic /c/imu of type sensor_msgs/Imu; choose one of: /a/imu (1");
}

TEST_F(BagImuTest, GyroAndAccelerometerOnTwoTopicsAreJoined) {
  const auto recording = read([](rosbag::Bag& bag) {
    bag.write("/tf_static", ros::Time(1.0), mounting("gyro", Eigen::Quaterniond::Identity()));
    bag.write("/tf_static", ros::Time(1.0),
              mounting("accel", turn(90.0, Eigen::Vector3d::UnitZ())));
    for (int i = 0; i < 40; ++i) {
      sensor_msgs::Imu gyro = imuAt(1.0 + 0.005 * i);
      gyro.header.frame_id = "gyro";
      gyro.orientation_covariance[0] = -1.0;
      gyro.linear_acceleration = geometry_msgs::Vector3();
      bag.write("/camera/gyro/sample", gyro.header.stamp, gyro);
      if (i % 3 != 0) continue;
      sensor_msgs::Imu accelerometer = imuAt(1.0 + 0.005 * i);
      accelerometer.header.frame_id = "accel";
      accelerometer.orientation_covariance[0] = -1.0;
      accelerometer.angular_velocity = geometry_msgs::Vector3();
      bag.write("/camera/accel/sample", accelerometer.header.stamp, accelerometer);
    }
  });
  const RecordedImu& imu = recording->imu();
  EXPECT_EQ(imu.topic, "/camera/gyro/sample + /camera/accel/sample");
  ASSERT_EQ(imu.samples.size(), 40U);
  for (const ImuSample& sample : imu.samples) {
    ASSERT_TRUE(sample.angular_velocity && sample.linear_acceleration);
    EXPECT_EQ(sample.angular_velocity->z(), 0.25);
    // The x axis of the accelerometer is the y axis of the gyro.
    EXPECT_NEAR((*sample.linear_acceleration - Eigen::Vector3d(0.0, 0.5, 9.75)).norm(), 0, 1e-9);
  }
  EXPECT_CONTAINS(recording->warnings().at(0), "they are joined by stamp");
}

TEST_F(BagImuTest, TheMissingHalfIsNamed) {
  const auto recording = read([](rosbag::Bag& bag) {
    for (int i = 1; i < 9; ++i) {
      sensor_msgs::Imu gyro = imuAt(i);
      gyro.header.frame_id = "base_link";
      gyro.orientation_covariance[0] = -1.0;
      gyro.linear_acceleration = geometry_msgs::Vector3();
      bag.write("/gyro", ros::Time(i), gyro);
    }
  });
  EXPECT_CONTAINS(recording->warnings().at(0),
                  "the messages on /gyro have no orientation (covariance[0] is -1) and no "
                  "accelerometer (always 0)");
}

TEST_F(BagImuTest, ValuesThatAreMarkedAsMissingAreNamed) {
  const auto recording = read([](rosbag::Bag& bag) {
    for (int i = 1; i < 9; ++i) {
      sensor_msgs::Imu imu = imuAt(i);
      imu.header.frame_id = "base_link";
      imu.orientation_covariance[0] = -1.0;
      imu.angular_velocity_covariance[0] = -1.0;
      imu.linear_acceleration_covariance[0] = -1.0;
      bag.write("/imu", ros::Time(i), imu);
    }
  });
  EXPECT_CONTAINS(recording->warnings().at(0),
                  "no orientation, gyro, accelerometer (covariance[0] is -1, although there are "
                  "values: correct the driver)");
}

TEST_F(BagImuTest, ACompleteImuIsPreferredToAFasterIncompleteOne) {
  const auto recording = read([](rosbag::Bag& bag) {
    for (int i = 1; i < 9; ++i) {
      sensor_msgs::Imu gyro = imuAt(i);
      gyro.orientation_covariance[0] = -1.0;
      gyro.linear_acceleration = geometry_msgs::Vector3();
      bag.write("/a_gyro", ros::Time(i), gyro);
      if (i % 2 == 0) bag.write("/imu", ros::Time(i), imuAt(i));
    }
  });
  EXPECT_EQ(recording->imu().topic, "/imu");
}

TEST_F(BagImuTest, BagWithoutImuHasNoSamples) {
  const auto recording = read([](rosbag::Bag&) {});
  EXPECT_TRUE(recording->imu().samples.empty());
  EXPECT_TRUE(recording->heights().empty());
  EXPECT_TRUE(recording->warnings().empty());
}

TEST_F(BagImuTest, UsesTheRangeFinderThatLooksDown) {
  const auto recording = read([](rosbag::Bag& bag) {
    bag.write("/tf_static", ros::Time(1.0), mounting("front", Eigen::Quaterniond::Identity()));
    bag.write("/tf_static", ros::Time(1.0), mounting("sonar", kDown, -0.25));
    bag.write("/a_front", ros::Time(1.0), rangeAt(1.0, 3.0F, "front"));
    bag.write("/height", ros::Time(1.5), rangeAt(1.5, 1.0F));
    bag.write("/height", ros::Time(2.5), rangeAt(2.5, 2.0F));
  });
  ASSERT_EQ(recording->heights().size(), 2U);
  EXPECT_EQ(recording->heights()[0].stamp, 1.5);
  EXPECT_EQ(recording->heights()[0].height_m, 1.25);
  EXPECT_EQ(recording->heights()[1].height_m, 2.25);
  EXPECT_CONTAINS(recording->description(), ", height /height");
}

TEST_F(BagImuTest, OnlyRangeFinderIsUsedWithoutTf) {
  const auto one = [](rosbag::Bag& bag) { bag.write("/r", ros::Time(1.0), rangeAt(1.0, 3.0F)); };
  const auto recording = read(one);
  EXPECT_EQ(recording->heights().size(), 1U);
  EXPECT_CONTAINS(recording->warnings().at(0), "tf has no mounting of the range finder /r");
  const auto two = read([&](rosbag::Bag& bag) {
    one(bag);
    bag.write("/s", ros::Time(1.0), rangeAt(1.0, 3.0F));
  });
  EXPECT_TRUE(two->heights().empty());
  EXPECT_CONTAINS(two->warnings().at(0), "choose one of: /r (1 messages), /s (1 messages)");
}

TEST_F(BagImuTest, ForwardRangeFinderIsUsedOnlyOnRequest) {
  const auto fill = [](rosbag::Bag& bag) {
    bag.write("/tf_static", ros::Time(1.0), mounting("sonar", Eigen::Quaterniond::Identity()));
    bag.write("/r", ros::Time(1.0), rangeAt(1.0, 3.0F));
  };
  EXPECT_TRUE(read(fill)->heights().empty());
  RecordingOptions options;
  options.height_topic = "r";
  const auto recording = read(fill, options);
  EXPECT_EQ(recording->heights().size(), 1U);
  EXPECT_CONTAINS(recording->warnings().at(0), "looks 90 degrees away from down");
}

TEST_F(BagImuTest, AChosenRangeFinderWithoutTfIsSaid) {
  RecordingOptions options;
  options.height_topic = "r";
  const auto recording =
      read([](rosbag::Bag& bag) { bag.write("/r", ros::Time(1.0), rangeAt(1.0, 3.0F)); }, options);
  EXPECT_EQ(recording->heights().size(), 1U);
  EXPECT_CONTAINS(recording->warnings().at(0), "tf has no mounting of the range finder /r");
}

TEST_F(BagImuTest, TwoLasersOnOneTopicHaveTheirOwnTimeBases) {
  const auto recording = read([](rosbag::Bag& bag) {
    for (const char* frame : {"front", "back"}) {
      bag.write("/tf_static", ros::Time(1.0), mounting(frame, Eigen::Quaterniond::Identity()));
    }
    for (int i = 0; i < 200; ++i) {
      sensor_msgs::LaserScan scan;
      scan.header.stamp = ros::Time(3.0 + 0.025 * i);
      scan.ranges = {1.0F};
      scan.header.frame_id = "front";
      bag.write("/scan", scan.header.stamp, scan);
      scan.header.frame_id = "back";
      if (i % 4 == 0) bag.write("/scan", scan.header.stamp, scan);
    }
  });
  RecordedScan scan;
  std::size_t count = 0;
  for (; recording->next(scan); ++count) EXPECT_EQ(scan.time, scan.scan.stamp) << count;
  EXPECT_EQ(count, 251U);
}

TEST(RealImus, HaveTheExpectedReadings) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto check = [&](const std::string& name, std::size_t count, std::size_t warnings) {
    const auto recording = openRecording(data + name);
    const RecordedImu& imu = recording->imu();
    EXPECT_EQ(imu.samples.size(), count) << name;
    EXPECT_EQ(recording->warnings().size(), warnings) << name;
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : imu.samples) {
      ASSERT_TRUE(sample.world_R_imu && sample.angular_velocity && sample.linear_acceleration);
      gravity += imu.base_T_imu.linear() * *sample.linear_acceleration / static_cast<double>(count);
    }
    if (count == 0) return;
    EXPECT_NEAR(gravity.norm(), 9.81, 0.6) << name;
    EXPECT_GT(gravity.z(), 9.0) << name;
  };
  check("/moving/overtakes.bag", 2634, 2);  // tf has neither the laser nor the IMU
  check("/moving/parallel.bag", 1695, 2);
  check("/moving/two_robots.bag", 3220, 0);
  check("/moving/people_wheelchair.bag", 0, 0);
  check("/cloud/kitti0000_slice.bag", 154, 2);
}

}  // namespace
}  // namespace kestrel
