// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/aiding_messages.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

TEST(AidingMessages, CovarianceOfAPlanarPose) {
  geometry_msgs::PoseWithCovariance message;
  for (std::size_t i = 0; i < 36; ++i) message.covariance[i] = static_cast<double>(i);
  Eigen::Matrix3d expected;
  expected << 0, 1, 5, 6, 7, 11, 30, 31, 35;
  EXPECT_EQ(planarCovariance(message), expected);
}

TEST(AidingMessages, PressureBecomesTheHeightOfTheStandardAtmosphere) {
  sensor_msgs::FluidPressure message;
  message.header.stamp = ros::Time(12.5);
  message.fluid_pressure = 101325.0;
  EXPECT_EQ(toHeightSample(message).height_m, 0.0);
  EXPECT_EQ(toHeightSample(message).stamp, 12.5);
  message.fluid_pressure = 89874.6;  // ISO 2533: 1000 m
  EXPECT_NEAR(toHeightSample(message).height_m, 1000.0, 0.5);
  message.fluid_pressure = 0.0;
  EXPECT_TRUE(std::isnan(toHeightSample(message).height_m));
}

TEST(AidingMessages, YawIsMeasuredFromEast) {
  sensor_msgs::MagneticField message;
  message.magnetic_field.x = 2e-5;
  message.magnetic_field.z = -4e-5;  // the field points down
  const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  EXPECT_NEAR(toYaw(message, level, 0.0)->yaw, kPi / 2.0, 1e-12);  // the vehicle points north
  EXPECT_NEAR(toYaw(message, level, 0.1)->yaw, kPi / 2.0 - 0.1, 1e-12);
  message.magnetic_field.x = 0.0;
  message.magnetic_field.y = 2e-5;  // north is to the left, so the vehicle points east
  EXPECT_NEAR(toYaw(message, level, 0.0)->yaw, 0.0, 1e-12);

  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  const Eigen::Vector3d field = tilt.conjugate() * Eigen::Vector3d(0.0, 2e-5, -4e-5);
  message.magnetic_field.x = field.x();
  message.magnetic_field.y = field.y();
  message.magnetic_field.z = field.z();
  EXPECT_NEAR(toYaw(message, tilt, 0.0)->yaw, 0.0, 1e-12);
}

TEST(AidingMessages, AFieldWithoutAHorizontalPartGivesNoYaw) {
  sensor_msgs::MagneticField message;
  message.magnetic_field.z = -4e-5;
  EXPECT_FALSE(toYaw(message, Eigen::Quaterniond::Identity(), 0.0));
  message.magnetic_field.x = std::nan("");
  EXPECT_FALSE(toYaw(message, Eigen::Quaterniond::Identity(), 0.0));
}

TEST(AidingMessages, PositionsAreRelativeToTheFirstFix) {
  LocalFixes fixes;
  sensor_msgs::NavSatFix message;
  message.latitude = 48.0;
  message.longitude = 11.0;
  message.altitude = 500.0;
  message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
  message.position_covariance = {4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 9.0};
  const Eigen::Vector3d start(1.0, 2.0, 3.0);
  ASSERT_TRUE(fixes.toPosition(message, start));
  EXPECT_EQ(fixes.toPosition(message, start)->position, start);
  EXPECT_EQ(fixes.toPosition(message, start)->covariance(2, 2), 9.0);
  message.latitude += 1e-4;  // at 48 degrees a degree of latitude is 111 200 m,
  EXPECT_NEAR(fixes.toPosition(message, start)->position.y(), 2.0 + 11.12, 0.01);
  message.latitude -= 1e-4;
  message.longitude += 1e-4;  // and one of longitude 74 630 m
  message.altitude += 7.0;
  const Eigen::Vector3d position = fixes.toPosition(message, start)->position;
  EXPECT_NEAR(position.x(), 1.0 + 7.463, 0.01);
  EXPECT_NEAR(position.z(), 10.0, 0.01);

  message.status.status = sensor_msgs::NavSatStatus::STATUS_NO_FIX;
  EXPECT_FALSE(fixes.toPosition(message, start));
}

}  // namespace
}  // namespace kestrel
