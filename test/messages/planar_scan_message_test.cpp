// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/planar_scan_message.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace kestrel {
namespace {

using Message = kestrel_slam::PlanarScan;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kDegree = M_PI / 180.0;
const ros::Time kStamp(1400000000, 250000000);

PlanarScan threeRays() {
  PlanarScan scan;
  scan.stamp = kStamp.toSec();
  scan.integrated_yaw = 7.1;  // not exactly representable as float
  scan.integrated_acceleration = Eigen::Vector2d(1.5, -0.1);
  scan.predicted = Pose2(0.7, -0.25, 0.5);
  scan.height = {1.3F, {0.1F, -0.02F}};
  scan.rays = {{{0.125F, -0.25F}, {3.0F, 4.0F}, true},
               {{0.0F, 0.0F}, {0.0F, 10.0F}, false},
               {{0.5F, 0.5F}, {-2.0F, 0.5F}, true}};
  return scan;
}

Message message() { return *toPlanarScanMessage(threeRays(), "base_stabilized", kStamp); }

std::string errorOf(const Message& message) {
  try {
    fromPlanarScanMessage(message);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(PlanarScanMessage, RoundTripIsExact) {
  const PlanarScan there = threeRays(), back = fromPlanarScanMessage(message());
  EXPECT_EQ(back.stamp, 1400000000.25);
  EXPECT_EQ(back.time, back.stamp) << "the mapper repairs the time later";
  EXPECT_EQ(back.integrated_yaw, there.integrated_yaw);
  EXPECT_EQ(back.integrated_acceleration, there.integrated_acceleration);
  EXPECT_EQ(back.predicted, there.predicted);
  EXPECT_EQ(back.height.base_m, there.height.base_m);
  EXPECT_EQ(back.height.slope, there.height.slope);
  ASSERT_EQ(back.rays.size(), there.rays.size());
  for (std::size_t i = 0; i < there.rays.size(); ++i) {
    EXPECT_EQ(back.rays[i].origin, there.rays[i].origin) << i;
    EXPECT_EQ(back.rays[i].end, there.rays[i].end) << i;
    EXPECT_EQ(back.rays[i].hit, there.rays[i].hit) << i;
  }
}

TEST(PlanarScanMessage, AbsentValuesStayAbsent) {
  PlanarScan scan = threeRays();
  scan.integrated_yaw.reset();
  scan.integrated_acceleration.reset();
  scan.predicted.reset();
  scan.height = ScanHeight();
  const PlanarScan back =
      fromPlanarScanMessage(*toPlanarScanMessage(scan, "base_stabilized", kStamp));
  EXPECT_FALSE(back.integrated_yaw);
  EXPECT_FALSE(back.integrated_acceleration);
  EXPECT_FALSE(back.predicted);
  EXPECT_FALSE(back.height.isKnown());
}

TEST(PlanarScanMessage, AScanOfAUtm30lxTakesAtMost26Kilobytes) {
  PlanarScan scan = threeRays();
  scan.rays.resize(1081, scan.rays.front());
  const auto large = toPlanarScanMessage(scan, "base_stabilized", kStamp);
  EXPECT_LE(ros::serialization::serializationLength(*large), 26000U);
}

TEST(PlanarScanMessage, AnEmptyScanIsValid) {
  const auto empty = toPlanarScanMessage(PlanarScan(), "base_stabilized", kStamp);
  EXPECT_TRUE(fromPlanarScanMessage(*empty).rays.empty());
}

struct Damage {
  const char* what;
  std::function<void(Message&)> apply;
  const char* answer;
};

TEST(PlanarScanMessage, RefusesInvalidMessages) {
  const Damage damages[] = {
      {"a short array", [](Message& m) { m.end_x.pop_back(); }, "different lengths: end_x 2"},
      {"a long array", [](Message& m) { m.hit.push_back(1); }, "hit 4"},
      {"no origins", [](Message& m) { m.origin_y.clear(); }, "origin_y 0"},
      {"NaN in x", [](Message& m) { m.end_x[1] = kNan; }, "ray 1 is not finite"},
      {"infinity in y", [](Message& m) { m.end_y[2] = kInfinity; }, "ray 2 is not finite"},
      {"NaN in the origin", [](Message& m) { m.origin_x[0] = kNan; }, "ray 0 is not finite"},
      {"an infinite yaw", [](Message& m) { m.integrated_yaw = kInfinity; },
       "integrated_yaw is not"},
      {"a part of a pose", [](Message& m) { m.predicted_yaw = kNan; }, "predicted is not finite"},
      {"a part of an acceleration", [](Message& m) { m.integrated_acceleration_x = kNan; },
       "integrated_acceleration is not finite"},
      {"an infinite height", [](Message& m) { m.height = kInfinity; }, "height is not finite"},
      {"a slope that is NaN", [](Message& m) { m.height_slope_y = kNan; }, "height is not finite"},
  };
  for (const Damage& damage : damages) {
    Message damaged = message();
    damage.apply(damaged);
    const std::string error = errorOf(damaged);
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
  add(0.0, 1.0, false);   // free space does not hide the hits behind it
  add(90.0, 2.0, false);  // only marks free space
  add(179.8, 4.0, true);  // the bin at the border between +180 and -180 degrees
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

TEST(LaserScanView, BinsFillTheCircleForAnyIncrement) {
  PlanarScan scan;
  for (int i = 0; i < 1000; ++i) {
    const double angle = -M_PI + i * 2.0 * M_PI / 999.0;  // both ends of the circle
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
