// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_scan_messages.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/recording.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

using Field = sensor_msgs::PointField;

constexpr double kStamp = 1317000000.25;  // s; exact in binary
const float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Builds a message field by field, in the byte order given by its flag.
class CloudMaker {
 public:
  CloudMaker(std::uint32_t width, std::uint32_t height, std::uint32_t point_step,
             std::uint32_t row_padding = 0, bool big_endian = false) {
    cloud_.header.stamp = ros::Time(1317000000, 250000000);
    cloud_.header.frame_id = "lidar";
    cloud_.width = width;
    cloud_.height = height;
    cloud_.point_step = point_step;
    cloud_.row_step = width * point_step + row_padding;
    cloud_.is_bigendian = big_endian;
    cloud_.data.assign(cloud_.row_step * height, 0xAB);
  }

  template <typename T>
  CloudMaker& field(const std::string& name, std::uint32_t offset, std::uint8_t type,
                    const std::vector<T>& values) {
    Field field;
    field.name = name;
    field.offset = offset;
    field.datatype = type;
    field.count = 1;
    cloud_.fields.push_back(field);
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::uint8_t* place = cloud_.data.data() + (i / cloud_.width) * cloud_.row_step +
                            (i % cloud_.width) * cloud_.point_step + offset;
      std::memcpy(place, &values[i], sizeof(T));
      if (cloud_.is_bigendian != 0) std::reverse(place, place + sizeof(T));
    }
    return *this;
  }

  CloudMaker& xyz() {
    return field<float>("x", 0, Field::FLOAT32, {1.0F, 4.0F})
        .field<float>("y", 4, Field::FLOAT32, {2.0F, 5.0F})
        .field<float>("z", 8, Field::FLOAT32, {3.0F, -6.0F});
  }

  sensor_msgs::PointCloud2& cloud() { return cloud_; }

 private:
  sensor_msgs::PointCloud2 cloud_;
};

void expectPoint(const PointCloud::Point& point, float x, float y, float z) {
  EXPECT_EQ(point.x, x);
  EXPECT_EQ(point.y, y);
  EXPECT_EQ(point.z, z);
}

std::string problemOf(const sensor_msgs::PointCloud2& cloud) {
  try {
    toPointCloud(cloud);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(BagCloud, ReadsCoordinatesAtAnyOffset) {
  CloudMaker maker(2, 1, 32);
  maker.field<float>("intensity", 0, Field::FLOAT32, {9.0F, 9.0F})
      .field<double>("z", 5, Field::FLOAT64, {3.0, -6.0})
      .field<float>("x", 17, Field::FLOAT32, {1.0F, 4.0F})
      .field<float>("y", 28, Field::FLOAT32, {2.0F, 5.0F});
  const PointCloud cloud = toPointCloud(maker.cloud());
  EXPECT_EQ(cloud.stamp, kStamp);
  ASSERT_EQ(cloud.points.size(), 2U);
  expectPoint(cloud.points[0], 1.0F, 2.0F, 3.0F);
  expectPoint(cloud.points[1], 4.0F, 5.0F, -6.0F);
  EXPECT_EQ(cloud.points[0].time, 0.0F);
  EXPECT_EQ(cloud.points[1].time, 0.0F);
}

TEST(BagCloud, ConvertsBigEndianData) {
  CloudMaker maker(2, 1, 24, 0, true);
  maker.field<double>("x", 0, Field::FLOAT64, {1.0, 4.0})
      .field<float>("y", 8, Field::FLOAT32, {2.0F, 5.0F})
      .field<float>("z", 12, Field::FLOAT32, {3.0F, -6.0F})
      .field<std::uint32_t>("t", 16, Field::UINT32, {0, 50'000'000});
  const PointCloud cloud = toPointCloud(maker.cloud());
  expectPoint(cloud.points[0], 1.0F, 2.0F, 3.0F);
  expectPoint(cloud.points[1], 4.0F, 5.0F, -6.0F);
  EXPECT_FLOAT_EQ(cloud.points[1].time, 0.05F);
}

TEST(BagCloud, SkipsRowPaddingAndKeepsMissingReturns) {
  CloudMaker maker(2, 2, 12, 20);
  maker.field<float>("x", 0, Field::FLOAT32, {1.0F, kNaN, 3.0F, 4.0F})
      .field<float>("y", 4, Field::FLOAT32, {1.5F, kNaN, 3.5F, 4.5F})
      .field<float>("z", 8, Field::FLOAT32, {0.0F, kNaN, 0.0F, 0.25F});
  const PointCloud cloud = toPointCloud(maker.cloud());
  ASSERT_EQ(cloud.points.size(), 4U);
  expectPoint(cloud.points[0], 1.0F, 1.5F, 0.0F);
  EXPECT_TRUE(std::isnan(cloud.points[1].x));
  expectPoint(cloud.points[2], 3.0F, 3.5F, 0.0F);
  expectPoint(cloud.points[3], 4.0F, 4.5F, 0.25F);
}

template <typename T>
std::vector<float> timesOf(const std::string& name, std::uint8_t type, T first, T second) {
  CloudMaker maker(2, 1, 20);
  maker.xyz().field<T>(name, 12, type, {first, second});
  const PointCloud cloud = toPointCloud(maker.cloud());
  return {cloud.points[0].time, cloud.points[1].time};
}

TEST(BagCloud, ReadsTheTimeFieldsOfCommonDrivers) {
  using Times = std::vector<float>;
  EXPECT_EQ(timesOf<float>("time", Field::FLOAT32, -0.0625F, 0.0F), (Times{-0.0625F, 0.0F}));
  EXPECT_EQ(timesOf<std::uint32_t>("t", Field::UINT32, 0, 99'000'000), (Times{0.0F, 0.099F}));
  EXPECT_EQ(timesOf<std::uint32_t>("offset_time", Field::UINT32, 1000000, 0), (Times{1e-3F, 0.0F}));
  EXPECT_EQ(timesOf<float>("time_offset", Field::FLOAT32, 0.0F, 0.5F), (Times{0.0F, 0.5F}));
  EXPECT_EQ(timesOf<double>("timestamp", Field::FLOAT64, kStamp, kStamp + 0.0625),
            (Times{0.0F, 0.0625F}));
  EXPECT_EQ(timesOf<double>("timestamp", Field::FLOAT64, 0.0, 0.0625), (Times{0.0F, 0.0625F}));
  const Times nanoseconds =
      timesOf<double>("timestamp", Field::FLOAT64, kStamp * 1e9, (kStamp + 0.0625) * 1e9);
  EXPECT_NEAR(nanoseconds[0], 0.0, 1e-6);
  EXPECT_NEAR(nanoseconds[1], 0.0625, 1e-6);
}

TEST(BagCloud, TimeFieldOfUnknownTypeIsIgnored) {
  EXPECT_EQ(timesOf<std::uint16_t>("t", Field::UINT16, 3, 4), (std::vector<float>{0.0F, 0.0F}));
}

TEST(BagCloud, InvalidTimesAndTimesOfMissingReturnsAreZero) {
  CloudMaker maker(3, 1, 20);
  maker.field<float>("x", 0, Field::FLOAT32, {kNaN, 0.0F, 1.0F})
      .field<float>("y", 4, Field::FLOAT32, {kNaN, 0.0F, 1.0F})
      .field<float>("z", 8, Field::FLOAT32, {kNaN, 0.0F, 1.0F})
      .field<double>("timestamp", 12, Field::FLOAT64, {0.0, 0.0, kStamp + 0.03125});
  const PointCloud cloud = toPointCloud(maker.cloud());
  EXPECT_EQ(cloud.points[0].time, 0.0F);
  EXPECT_EQ(cloud.points[1].time, 0.0F);
  EXPECT_EQ(cloud.points[2].time, 0.03125F);
  EXPECT_EQ(timesOf<float>("time", Field::FLOAT32, kNaN, 0.5F), (std::vector<float>{0.0F, 0.5F}));
}

TEST(BagCloud, ErrorsDescribeTheProblem) {
  CloudMaker no_z(1, 1, 16);
  no_z.field<float>("x", 0, Field::FLOAT32, {1.0F}).field<float>("rgb", 4, Field::FLOAT32, {1.0F});
  EXPECT_EQ(problemOf(no_z.cloud()), "the cloud has no field y, z; its fields: x, rgb");
  EXPECT_EQ(problemOf(sensor_msgs::PointCloud2()),
            "the cloud has no field x, y, z; its fields: none");

  CloudMaker good(2, 1, 16);
  good.xyz();
  EXPECT_EQ(problemOf(good.cloud()), "nothing thrown");
  auto bad = good.cloud();
  bad.width = 0;
  EXPECT_EQ(problemOf(bad), "the cloud has zero points");
  bad = good.cloud();
  bad.data.pop_back();
  EXPECT_EQ(problemOf(bad), "the payload of the cloud has 31 bytes, fewer than 1 rows of 32 bytes");
  bad = good.cloud();
  bad.row_step = 31;
  EXPECT_CONTAINS(problemOf(bad), "a row of the cloud has 31 bytes, too few for 2 points of 16");
  bad = good.cloud();
  bad.fields[1].datatype = Field::INT16;
  EXPECT_CONTAINS(problemOf(bad), "field y of the cloud has the unsupported type 3");
  bad = good.cloud();
  bad.fields[2].offset = 13;
  EXPECT_CONTAINS(problemOf(bad), "field z of the cloud lies outside of its point: 13 + 4 bytes");
  bad = good.cloud();
  bad.point_step = 0;
  EXPECT_CONTAINS(problemOf(bad), "lies outside of its point");
}

/// A random number that is small, at a limit, or arbitrary.
std::uint32_t wildNumber(std::mt19937& random) {
  const std::uint32_t any = static_cast<std::uint32_t>(random());
  switch (random() % 4U) {
    case 0:
      return any % 40U;
    case 1:
      return std::numeric_limits<std::uint32_t>::max() - any % 3U;
    case 2:
      return 1U << (any % 32U);
    default:
      return any;
  }
}

TEST(BagCloud, RandomHeadersDoNotCrash) {
  std::mt19937 random(7);
  const std::vector<std::string> names = {"x", "y", "z", "time", "t", "timestamp", "ring"};
  int accepted = 0, refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    CloudMaker maker(2, 1, 24);
    maker.xyz();
    sensor_msgs::PointCloud2& cloud = maker.cloud();
    if (random() % 2U == 0U) cloud.width = wildNumber(random);
    if (random() % 2U == 0U) cloud.height = wildNumber(random);
    if (random() % 2U == 0U) cloud.point_step = wildNumber(random);
    if (random() % 2U == 0U) cloud.row_step = wildNumber(random);
    cloud.is_bigendian = random() % 2U == 0U;
    cloud.data.resize(random() % 200U, static_cast<std::uint8_t>(random()));
    Field& field = cloud.fields[random() % 3U];
    if (random() % 2U == 0U) field.offset = wildNumber(random);
    if (random() % 4U == 0U) field.datatype = static_cast<std::uint8_t>(random() % 12U);
    if (random() % 2U == 0U) {
      Field extra;
      extra.name = names[random() % names.size()];
      extra.offset = wildNumber(random);
      extra.datatype = static_cast<std::uint8_t>(random() % 12U);
      cloud.fields.push_back(extra);
    }
    try {
      const PointCloud result = toPointCloud(cloud);
      EXPECT_EQ(result.points.size(), std::size_t{cloud.width} * cloud.height);
      for (const PointCloud::Point& point : result.points) EXPECT_TRUE(std::isfinite(point.time));
      ++accepted;
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 1000);
}

class BagCloudRecording : public ::testing::Test {
 protected:
  void write(bool with_laser) {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    for (int i = 1; i <= 3; ++i) {
      CloudMaker maker(2, 1, 12);
      maker.xyz().cloud().header.stamp = ros::Time(i);
      if (i == 2) maker.cloud().fields.pop_back();
      bag.write("/points", ros::Time(i), maker.cloud());
      if (with_laser && i == 1) bag.write("/scan", ros::Time(i), laserScan());
    }
    bag.close();
  }

  static sensor_msgs::LaserScan laserScan() {
    sensor_msgs::LaserScan scan;
    scan.header.stamp = ros::Time(1.0);
    scan.header.frame_id = "laser";
    scan.angle_increment = 0.5F;
    scan.ranges = {1.0F, 2.0F, 3.0F};
    return scan;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.file("a.bag");
};

TEST_F(BagCloudRecording, CloudsAreUsedIfTheBagHasNoLaser) {
  write(false);
  const auto recording = openRecording(path_);
  EXPECT_CONTAINS(recording->description(), "rosbag, 3 clouds on /points, laser lidar on lidar");
  RecordedScan scan;
  ASSERT_TRUE(recording->next(scan));
  ASSERT_TRUE(scan.cloud);
  EXPECT_EQ(scan.scan.stamp, 1.0);
  EXPECT_EQ(scan.cloud->stamp, 1.0);
  EXPECT_TRUE(scan.scan.ranges.empty());
  expectPoint(scan.cloud->points.at(1), 4.0F, 5.0F, -6.0F);
  ASSERT_TRUE(recording->next(scan));
  EXPECT_EQ(scan.scan.stamp, 3.0);
  EXPECT_FALSE(recording->next(scan));
  EXPECT_EQ(recording->skipped().at("unusable cloud"), 1U);
  EXPECT_CONTAINS(recording->warnings().back(), "the cloud has no field z; its fields: x, y");
}

TEST_F(BagCloudRecording, OptionsSelectLaserOrClouds) {
  write(true);
  EXPECT_CONTAINS(openRecording(path_)->description(), "1 scans on /scan");
  RecordingOptions options;
  options.scan_topic = "points";
  EXPECT_CONTAINS(openRecording(path_, options)->description(), "3 clouds on /points");
  options = RecordingOptions();
  options.prefer_clouds = true;
  EXPECT_CONTAINS(openRecording(path_, options)->description(), "3 clouds on /points");
}

TEST(RealClouds, AllFramesOfTheKittiBagAreRead) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto recording = openRecording(data + "/cloud/kitti0000_slice.bag");
  RecordedScan scan;
  std::size_t frames = 0;
  for (; recording->next(scan); ++frames) {
    ASSERT_TRUE(scan.cloud);
    if (frames == 0) {
      EXPECT_EQ(scan.cloud->points.size(), 30277U);
    }
    for (const PointCloud::Point& point : scan.cloud->points) {
      // The bag was cropped to this height.
      ASSERT_GT(point.z, -1.5F);
      ASSERT_LT(point.z, 0.2F);
      ASSERT_LT(std::hypot(point.x, point.y), 51.0F);
      ASSERT_GT(std::hypot(point.x, point.y), 2.0F);
    }
  }
  EXPECT_EQ(frames, 154U);
  EXPECT_TRUE(recording->skipped().empty());
}

}  // namespace
}  // namespace kestrel
