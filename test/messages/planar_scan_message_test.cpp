// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/planar_scan_message.h"

#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace kestrel {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kDegree = M_PI / 180.0;
const ros::Time kStamp(1400000000, 250000000);

PlanarScan threeRays() {
  PlanarScan scan;
  scan.stamp = kStamp.toSec();
  scan.integrated_yaw = 7.25;
  scan.integrated_acceleration = Eigen::Vector2d(1.5, -0.5);
  scan.predicted = Pose2(0.75, -0.25, 0.5);
  scan.rays = {{{0.125F, -0.25F}, {3.0F, 4.0F}, true},
               {{0.0F, 0.0F}, {0.0F, 10.0F}, false},
               {{0.5F, 0.5F}, {-2.0F, 0.5F}, true}};
  return scan;
}

PointCloud2 message() { return *toPlanarScanMessage(threeRays(), "base_stabilized", kStamp); }

void expectEqual(const PlanarScan& a, const PlanarScan& b) {
  EXPECT_EQ(a.integrated_yaw, b.integrated_yaw);
  EXPECT_EQ(a.integrated_acceleration, b.integrated_acceleration);
  EXPECT_EQ(a.predicted, b.predicted);
  ASSERT_EQ(a.rays.size(), b.rays.size());
  for (std::size_t i = 0; i < a.rays.size(); ++i) {
    EXPECT_EQ(a.rays[i].origin, b.rays[i].origin) << i;
    EXPECT_EQ(a.rays[i].end, b.rays[i].end) << i;
    EXPECT_EQ(a.rays[i].hit, b.rays[i].hit) << i;
  }
}

std::string errorOf(const PointCloud2& cloud) {
  try {
    fromPlanarScanMessage(cloud);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

void setFloat(PointCloud2& cloud, std::size_t point, const std::string& field, float value) {
  sensor_msgs::PointCloud2Iterator<float> place(cloud, field);
  *(place + static_cast<int>(point)) = value;
}

TEST(PlanarScanMessage, ThereAndBackIsExact) {
  const PlanarScan back = fromPlanarScanMessage(message());
  expectEqual(back, threeRays());
  EXPECT_EQ(back.stamp, 1400000000.25);
  EXPECT_EQ(back.time, back.stamp) << "until somebody repairs it";
}

TEST(PlanarScanMessage, WithoutAGyroThereIsNoHeading) {
  PlanarScan scan = threeRays();
  scan.integrated_yaw.reset();
  const auto cloud = toPlanarScanMessage(scan, "base_stabilized", kStamp);
  EXPECT_FALSE(fromPlanarScanMessage(*cloud).integrated_yaw);
}

TEST(PlanarScanMessage, WithoutAnAccelerometerThereIsNoSpeed) {
  PlanarScan scan = threeRays();
  scan.integrated_acceleration.reset();
  scan.predicted.reset();
  const auto cloud = toPlanarScanMessage(scan, "base_stabilized", kStamp);
  EXPECT_FALSE(fromPlanarScanMessage(*cloud).integrated_acceleration);
  EXPECT_FALSE(fromPlanarScanMessage(*cloud).predicted);
  EXPECT_EQ(fromPlanarScanMessage(*cloud).integrated_yaw, scan.integrated_yaw);
}

TEST(PlanarScanMessage, HasTheDocumentedFields) {
  PointCloud2 cloud = message();
  EXPECT_EQ(cloud.header.frame_id, "base_stabilized");
  EXPECT_EQ(cloud.header.stamp, kStamp);
  EXPECT_EQ(cloud.width * cloud.height, 3U);
  EXPECT_EQ(cloud.data.size(), 3U * cloud.point_step);
  const std::pair<const char*, float> expected[] = {{"x", 3.0F},
                                                    {"y", 4.0F},
                                                    {"z", 0.0F},
                                                    {"hit", 1.0F},
                                                    {"origin_x", 0.125F},
                                                    {"origin_y", -0.25F},
                                                    {"heading", 7.25F},
                                                    {"speed_x", 1.5F},
                                                    {"speed_y", -0.5F},
                                                    {"predicted_x", 0.75F},
                                                    {"predicted_y", -0.25F},
                                                    {"predicted_yaw", 0.5F}};
  EXPECT_EQ(cloud.fields.size(), 12U);
  for (const auto& [name, value] : expected) {
    EXPECT_EQ(*sensor_msgs::PointCloud2ConstIterator<float>(cloud, name), value) << name;
  }
}

TEST(PlanarScanMessage, AnEmptyScanIsValid) {
  const auto cloud = toPlanarScanMessage(PlanarScan(), "base_stabilized", kStamp);
  EXPECT_TRUE(fromPlanarScanMessage(*cloud).rays.empty());
}

/// Other programs may add fields, order them at will, and lay the points out as an image.
TEST(PlanarScanMessage, ReadsAnyLayout) {
  PointCloud2 cloud;
  const char* names[] = {"heading", "rgb", "origin_y", "origin_x", "hit", "y", "x"};
  constexpr std::uint32_t kPadding = 3;  // nothing is aligned
  for (const char* name : names) {
    PointField field;
    field.name = name;
    field.offset = kPadding + 4 * static_cast<std::uint32_t>(cloud.fields.size());
    field.datatype = PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
  }
  cloud.point_step = kPadding + 4 * 7;
  cloud.width = 1;
  cloud.height = 3;
  cloud.row_step = cloud.point_step + 5;
  cloud.data.assign(3 * cloud.row_step, 0xff);
  PlanarScan scan = threeRays();
  scan.integrated_acceleration.reset();  // has no field,
  scan.predicted.reset();                // neither has this
  for (std::size_t i = 0; i < 3; ++i) {
    const PlanarRay& ray = scan.rays[i];
    const float values[] = {
        7.25F,       kNan,       ray.origin.y(), ray.origin.x(), ray.hit ? 1.0F : 0.0F,
        ray.end.y(), ray.end.x()};
    std::memcpy(cloud.data.data() + i * cloud.row_step + kPadding, values, sizeof values);
  }
  expectEqual(fromPlanarScanMessage(cloud), scan);
}

struct Damage {
  const char* what;
  std::function<void(PointCloud2&)> apply;
  const char* answer;
};

TEST(PlanarScanMessage, RefusesWhatItCannotRead) {
  const Damage damages[] = {
      {"big-endian", [](PointCloud2& c) { c.is_bigendian = true; }, "big-endian"},
      {"no fields", [](PointCloud2& c) { c.fields.clear(); }, "no field 'x'"},
      {"a missing field", [](PointCloud2& c) { c.fields[6].name = "yaw"; }, "no field 'heading'"},
      {"another type", [](PointCloud2& c) { c.fields[3].datatype = PointField::UINT8; },
       "field 'hit' is not a single float32"},
      {"an array", [](PointCloud2& c) { c.fields[1].count = 2; }, "field 'y' is not a single"},
      {"a field outside", [](PointCloud2& c) { c.fields[0].offset = 45; },
       "field 'x' lies beyond point_step 48"},
      {"a huge offset", [](PointCloud2& c) { c.fields[0].offset = 0xffffffffU; },
       "field 'x' lies beyond"},
      {"a short payload", [](PointCloud2& c) { c.data.pop_back(); },
       "it has 143 bytes of data, its sizes promise 144"},
      {"a huge size", [](PointCloud2& c) { c.width = c.height = c.row_step = 0xffffffffU; },
       "is less than"},
      {"rows that overlap", [](PointCloud2& c) { c.height = 2, c.row_step = 0; },
       "row_step 0 is less than the 144 bytes"},
      {"NaN in x", [](PointCloud2& c) { setFloat(c, 1, "x", kNan); }, "not finite"},
      {"infinity in y", [](PointCloud2& c) { setFloat(c, 2, "y", kInfinity); }, "not finite"},
      {"NaN in hit", [](PointCloud2& c) { setFloat(c, 0, "hit", kNan); }, "not finite"},
      {"NaN in the origin", [](PointCloud2& c) { setFloat(c, 0, "origin_y", kNan); }, "not finite"},
      {"an infinite heading", [](PointCloud2& c) { setFloat(c, 0, "heading", kInfinity); },
       "heading is infinite"},
  };
  for (const Damage& damage : damages) {
    PointCloud2 cloud = message();
    damage.apply(cloud);
    const std::string error = errorOf(cloud);
    EXPECT_NE(error.find(damage.answer), std::string::npos) << damage.what << ": " << error;
  }
}

TEST(LaserScanView, HasTheNearestHitOfEveryBin) {
  PlanarScan scan;
  const auto add = [&](double degrees, double range, bool hit) {
    const Eigen::Vector2d end =
        range * Eigen::Vector2d(std::cos(degrees * kDegree), std::sin(degrees * kDegree));
    scan.rays.push_back({Eigen::Vector2f::Zero(), end.cast<float>(), hit});
  };
  add(0.2, 5.0, true);
  add(-0.3, 3.0, true);   // the same bin, nearer
  add(0.0, 1.0, false);   // nothing there: does not hide the returns behind
  add(90.0, 2.0, false);  // only clears
  add(179.8, 4.0, true);  // the bin around the seam
  add(45.0, 31.0, true);  // beyond the range of the view
  const auto view = toLaserScanView(scan, "base_stabilized", kStamp, kDegree, 30.0);
  ASSERT_EQ(view->ranges.size(), 360U);
  EXPECT_EQ(view->header.frame_id, "base_stabilized");
  EXPECT_EQ(view->header.stamp, kStamp);
  EXPECT_FLOAT_EQ(view->angle_min, static_cast<float>(-M_PI));
  EXPECT_FLOAT_EQ(view->angle_increment, static_cast<float>(kDegree));
  EXPECT_FLOAT_EQ(view->angle_max, static_cast<float>(M_PI - kDegree));
  EXPECT_EQ(view->range_max, 30.0F);
  EXPECT_FLOAT_EQ(view->ranges[180], 3.0F);
  EXPECT_EQ(view->ranges[270], kInfinity);
  EXPECT_FLOAT_EQ(view->ranges[0], 4.0F);
  EXPECT_EQ(view->ranges[225], kInfinity);
  EXPECT_TRUE(std::isnan(view->ranges[10]));
}

TEST(LaserScanView, BinsFillTheTurnWhateverTheIncrement) {
  PlanarScan scan;
  for (int i = 0; i < 1000; ++i) {
    const double angle = -M_PI + i * 2.0 * M_PI / 999.0;  // both ends of the turn
    scan.rays.push_back({Eigen::Vector2f::Zero(),
                         Eigen::Vector2d(std::cos(angle), std::sin(angle)).cast<float>(), true});
  }
  const auto view = toLaserScanView(scan, "base_stabilized", kStamp, 0.1, 30.0);
  ASSERT_EQ(view->ranges.size(), 63U);
  EXPECT_NEAR(view->angle_increment * 63.0, 2.0 * M_PI, 1e-5);
  for (const float range : view->ranges) EXPECT_FLOAT_EQ(range, 1.0F);
  EXPECT_THROW(toLaserScanView(scan, "base_stabilized", kStamp, 0.0, 30.0), std::invalid_argument);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
