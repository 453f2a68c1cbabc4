// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "bad_input_flight.h"

namespace kestrel {
namespace {

TEST_F(PoseFilterBadInput, RejectsInvalidPoses) {
  fly();
  PoseMeasurement pose = flight_.pose(24.99);
  const auto refuse = [&](const std::string& reason) {
    const auto counts = status().of(FilterSensor::kPose).rejected;
    const std::size_t before = counts.count(reason) > 0 ? counts.at(reason) : 0U;
    EXPECT_FALSE(filter_.addPose(pose)) << reason;
    EXPECT_EQ(status().of(FilterSensor::kPose).rejected.at(reason), before + 1U) << reason;
  };
  pose.covariance(0, 0) = -1.0;
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance = Eigen::Matrix3d::Zero();
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance << 1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0;  // indefinite
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance << 1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0;  // not symmetric
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance.setConstant(kNan);
  EXPECT_FALSE(filter_.addPose(pose));
  EXPECT_EQ(status().of(FilterSensor::kPose).rejected.at("covariance not positive definite"), 5U);
  pose = flight_.pose(24.99);
  pose.pose.x = kNan;
  refuse("not finite");
  pose = flight_.pose(24.99);
  pose.stamp -= 3600.0;
  refuse("too old");
  pose.stamp += 7200.0;
  refuse("from the future");
  pose.stamp = kNan;
  refuse("bad stamp");
  pose = flight_.pose(24.5);
  EXPECT_TRUE(filter_.addPose(pose));
  refuse("repeated");
  expectGood();
}

TEST_F(PoseFilterBadInput, RejectsOutlierPoses) {
  int i = 0;
  feeding_.pose = [&](double time, PoseMeasurement& pose) {
    if (time > 5.0 && ++i % 5 == 0) pose.pose = Pose2(3.0, -2.0, 1.0) * pose.pose;
    return true;
  };
  fly();
  EXPECT_GT(status().of(FilterSensor::kPose).rejected.at("innovation gate"), 90U);
  EXPECT_EQ(status().reinitializations, 0U);
  expectGood();
}

TEST_F(PoseFilterBadInput, RejectsInvalidHeights) {
  fly();
  const double stamp = flight_.start_stamp + 24.99;
  for (const double height : {kNan, kInfinity, -kInfinity, -1.0, 0.0, 1e3}) {
    EXPECT_FALSE(filter_.addRange({stamp, height})) << height;
    EXPECT_FALSE(filter_.addFloorHeight({stamp, height})) << height;
  }
  EXPECT_FALSE(filter_.addBarometer({stamp, kNan}));
  EXPECT_FALSE(filter_.addYaw({stamp, kNan, 0.1}));
  EXPECT_FALSE(filter_.addPosition({stamp, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()}));
  expectGood();
}

TEST_F(PoseFilterBadInput, RejectsSpikesOfTheRangeFinder) {
  int i = 0;
  feeding_.range = [&](double time, HeightSample& range) {
    if (time > 5.0 && ++i % 7 == 0) range.height_m = 3.0 + 0.5 * (i % 3);
    return true;
  };
  fly();
  EXPECT_GT(status().of(FilterSensor::kRange).rejected.at("step below"), 50U);
  EXPECT_EQ(filter_.output()->ground_m, 0.0);
  expectGood();
}

}  // namespace
}  // namespace kestrel
