// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/filter/pose_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <stdexcept>

#include "filter_flight.h"
#include "kestrel_slam/geometry/pose3.h"

namespace kestrel {
namespace {

TEST(PoseFilter, FollowsAFlightAndLearnsTheBiases) {
  const FilterFlight flight;
  PoseFilter filter;
  double worst_position = 0.0, worst_velocity = 0.0, worst_tilt = 0.0, worst_yaw = 0.0;
  Feeding feeding;
  feeding.until_s = 40.0;
  feeding.output = [&](double time, const FilterOutput& output) {
    if (time < 5.0) return;
    const FilterErrors errors = errorsOf(flight, output);
    worst_position = std::max(worst_position, errors.position_m);
    worst_velocity = std::max(worst_velocity, errors.velocity);
    worst_tilt = std::max(worst_tilt, errors.tilt_rad);
    worst_yaw = std::max(worst_yaw, errors.yaw_rad);
  };
  feed(flight, feeding, filter);
  EXPECT_LT(worst_position, 0.03);
  EXPECT_LT(worst_velocity, 0.05);
  EXPECT_LT(worst_tilt, 0.005);
  EXPECT_LT(worst_yaw, 0.01);
  const FilterOutput& last = *filter.output();
  EXPECT_LT((last.gyro_bias - flight.gyro_bias).cwiseAbs().maxCoeff(), 0.001);
  EXPECT_NEAR(last.accelerometer_bias.z(), flight.accelerometer_bias.z(), 0.005);
  const FilterStatus status = statusAtEnd(filter, flight, 40.0);
  EXPECT_EQ(status.health, FilterHealth::kOk);
  EXPECT_FALSE(status.started_in_air);
  EXPECT_EQ(status.reinitializations, 0U);
  EXPECT_TRUE(status.resets.empty());
  EXPECT_NEAR(status.imu_rate_hz, 100.0, 0.1);
  EXPECT_GT(status.of(FilterSensor::kPose).accepted, 900U);
}

TEST(PoseFilter, InitializesInFlight) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.from_s = 6.0;
  feeding.until_s = 20.0;
  feed(flight, feeding, filter);
  EXPECT_TRUE(statusAtEnd(filter, flight, 20.0).started_in_air);
  const FilterErrors errors = errorsOf(flight, *filter.output());
  EXPECT_LT(errors.position_m, 0.03);
  EXPECT_LT(errors.velocity, 0.08);
  EXPECT_LT(errors.tilt_rad, 0.01);
}

/// The frames: odom_T_base is smooth and map_T_odom is level.
TEST(PoseFilter, OdomFollowsTheVelocityDuringCorrections) {
  const FilterFlight flight;
  PoseFilter filter;
  std::optional<FilterOutput> last;
  double worst = 0.0, corrected = 0.0;
  Feeding feeding;
  feeding.pose = [](double time, PoseMeasurement& pose) {
    if (time > 10.0) pose.pose = Pose2(0.5, -0.3, 0.2) * pose.pose;  // a correction of the map
    return true;
  };
  feeding.output = [&](double, const FilterOutput& now) {
    const Eigen::Isometry3d product = now.map_T_odom * now.odom_T_base;
    EXPECT_LT((product.matrix() - now.map_T_base.matrix()).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_NEAR(now.map_T_odom.linear()(2, 2), 1.0, 1e-12);
    if (last) {
      const double step = (now.odom_T_base.translation() - last->odom_T_base.translation()).norm();
      worst = std::max(worst, step - 0.01 * std::max(now.velocity.norm(), last->velocity.norm()));
      corrected = std::max(corrected,
                           (now.map_T_base.translation() - last->map_T_base.translation()).norm());
    }
    last = now;
  };
  feed(flight, feeding, filter);
  EXPECT_LT(worst, 0.001);
  EXPECT_GT(corrected, 0.3);  // the jump is in map_T_odom
  EXPECT_EQ(statusAtEnd(filter, flight, 20.0).reinitializations, 1U);
  EXPECT_NEAR(filter.output()->map_T_base.translation().x(),
              (Pose2(0.5, -0.3, 0.2) * flight.pose(19.99).pose).x, 0.03);
}

TEST(PoseFilter, DelayedMeasurementsGiveTheSameResult) {
  const FilterFlight flight;
  Feeding feeding;
  feeding.pose_noise_m = feeding.gyro_noise = feeding.accelerometer_noise = 0.0;
  feeding.range_noise_m = 0.0;
  feeding.imu_hz = 200.0;
  PoseFilter in_order, late;
  feeding.pose_late_s = 0.0;
  // Between two IMU samples, so that the state must be propagated to this time.
  feeding.pose = [](double, PoseMeasurement& pose) { return pose.stamp += 1e-3, true; };
  feed(flight, feeding, in_order);
  feeding.pose_late_s = 0.3;
  feed(flight, feeding, late);
  // The poses of the last 0.3 s are missing so far.
  for (int i = 3940; i < 4000; ++i) {
    if (i % feeding.per_pose != 0) continue;
    PoseMeasurement pose = flight.pose(i / 200.0);
    pose.stamp += 1e-3;
    late.addPose(pose);
  }
  const FilterOutput &a = *in_order.output(), &b = *late.output();
  ASSERT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.map_T_base.matrix(), b.map_T_base.matrix());
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.gyro_bias, b.gyro_bias);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(PoseFilter, RepeatedCorrelatedPosesDoNotMakeItOverconfident) {
  FilterFlight flight;
  flight.rest_s = 1e9;
  PoseFilterConfig config;
  config.motion.zero_velocity = false;
  PoseFilter filter(config);
  Feeding feeding;
  feeding.until_s = 60.0;
  feeding.pose_noise_m = 0.0;
  const double map_error_m = 0.005;  // error of the map, the same in every pose
  feeding.pose = [&](double, PoseMeasurement& pose) { return pose.pose.x += map_error_m, true; };
  feeding.output = [&](double time, const FilterOutput& output) {
    if (time < 2.0) return;
    EXPECT_GE(output.covariance(kPosition, kPosition), 0.99 * 2.5e-5) << time;
    EXPECT_GE(output.covariance(kPosition + 1, kPosition + 1), 0.99 * 2.5e-5) << time;
  };
  feed(flight, feeding, filter);
  EXPECT_EQ(
      statusAtEnd(filter, flight, 60.0).of(FilterSensor::kPose).rejected.count("innovation gate"),
      0U);
}

/// In a shifted map the velocity is correct. The correlation of position and velocity must allow
/// for that.
TEST(PoseFilter, AShiftedMapDoesNotContradictTheVelocity) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 30.0;
  feeding.pose_noise_m = 0.0;
  const double shift_m = 0.01;
  feeding.pose = [&](double, PoseMeasurement& pose) { return pose.pose.x += shift_m, true; };
  double joint = 0.0, position_only = 0.0;  // sums of squared normalized errors
  feeding.output = [&](double time, const FilterOutput& output) {
    if (time < 5.0) return;
    const FilterFlight::Truth truth = flight.at(time);
    const Eigen::Vector2d error(truth.position.x() - output.map_T_base.translation().x(),
                                truth.velocity.x() - output.velocity.x());
    Eigen::Matrix2d p;
    p << output.covariance(kPosition, kPosition), output.covariance(kPosition, kVelocity),
        output.covariance(kVelocity, kPosition), output.covariance(kVelocity, kVelocity);
    position_only += error.x() * error.x() / p(0, 0);
    joint += error.dot(p.inverse() * error);
  };
  feed(flight, feeding, filter);
  EXPECT_LT(joint, 3.5 * position_only);
}

/// The poses of the mapper only repeat the prediction of the filter; their covariance grows as in
/// dead reckoning.
TEST(PoseFilter, ABiasedPredictionDoesNotConfirmItself) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 25.0;
  double initial_speed_sigma = 0.0, error_m = 0.0, sigma_m = 0.0;
  feeding.imu = [](double time, ImuSample& sample) {
    if (time > 10.0) sample.linear_acceleration->x() += 0.05;  // the bias changes
    return true;
  };
  feeding.pose = [&](double time, PoseMeasurement& pose) {
    if (time < 10.0) return true;
    const auto predicted = filter.at(pose.stamp);
    if (!predicted) return false;
    const Eigen::Vector3d place = predicted->map_T_base.translation();
    pose.pose =
        Pose2(place.x(), place.y(), yawOf(Eigen::Quaterniond(predicted->map_T_base.linear())));
    const double seconds = time - 10.0;
    // As in PoseUncertainty.
    const double sigma = 0.05 * seconds + 0.025 * seconds * seconds + 0.005;
    pose.covariance.diagonal().head<2>().setConstant(sigma * sigma);
    return true;
  };
  feeding.output = [&](double time, const FilterOutput& output) {
    const double sigma = std::sqrt(output.covariance(kVelocity, kVelocity));
    if (time < 10.0) initial_speed_sigma = sigma;
    error_m = errorsOf(flight, output).position_m;
    sigma_m = std::sqrt(output.covariance.block<2, 2>(kPosition, kPosition).trace());
  };
  feed(flight, feeding, filter);
  EXPECT_GT(error_m, 0.3);            // the prediction is biased,
  EXPECT_GT(sigma_m, error_m / 3.0);  // and the covariance shows it
  EXPECT_GT(std::sqrt(filter.output()->covariance(kVelocity, kVelocity)), initial_speed_sigma);
}

TEST(PoseFilter, CoastsWithoutPosesAndReportsIt) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 12.0;
  feeding.pose = [](double time, PoseMeasurement&) { return time < 10.0; };
  feed(flight, feeding, filter);
  EXPECT_LT(errorsOf(flight, *filter.output()).position_m, 0.3);
  EXPECT_EQ(statusAtEnd(filter, flight, 12.0).health, FilterHealth::kCoasting);
  EXPECT_GT(filter.output()->covariance(kPosition, kPosition), 1e-4);
}

TEST(PoseFilter, DoesNotFuseAlongAnUnobservableDirection) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  // From 10 s on the mapper is in a corridor along x. Its pose claims to know x, and is wrong.
  feeding.pose = [](double time, PoseMeasurement& pose) {
    if (time < 10.0) return true;
    pose.unobservable = Eigen::Vector2d::UnitX();
    pose.pose.x += 0.5 * (time - 10.0);
    return true;
  };
  feeding.until_s = 13.0;
  feed(flight, feeding, filter);
  const FilterOutput& output = *filter.output();
  const Eigen::Vector3d truth = flight.position(output.stamp - flight.start_stamp);
  const Eigen::Vector3d error = output.map_T_base.translation() - truth;
  const double sigma_x = std::sqrt(output.covariance(kPosition, kPosition));
  EXPECT_GT(sigma_x, 0.01);
  EXPECT_LT(std::abs(error.x()), std::min(0.5, 3.0 * sigma_x));
  EXPECT_LT(std::abs(error.y()), 0.02);
  EXPECT_LT(output.covariance(kPosition + 1, kPosition + 1), 1e-3);
  const FilterStatus status = statusAtEnd(filter, flight, 13.0);
  EXPECT_EQ(status.health, FilterHealth::kCoasting);
  EXPECT_NE(status.message.find("along"), std::string::npos) << status.message;
  EXPECT_EQ(status.reinitializations, 0U);
  EXPECT_GT(status.of(FilterSensor::kGravityDirection).accepted, 2U);
}

TEST(PoseFilter, SetPoseWorksBeforeAndAfterTheInitialization) {
  const FilterFlight flight;
  PoseFilter filter;
  const Eigen::Matrix3d covariance = 0.01 * Eigen::Matrix3d::Identity();
  EXPECT_FALSE(filter.setPose(Pose2(), Eigen::Matrix3d::Zero()));
  EXPECT_TRUE(filter.setPose(Pose2(3.0, 4.0, 1.0), covariance));
  Feeding feeding;
  feeding.per_pose = 0;
  feeding.until_s = 1.4;
  feed(flight, feeding, filter);
  ASSERT_TRUE(filter.output());
  EXPECT_NEAR(filter.output()->map_T_base.translation().x(), 3.0, 1e-3);
  EXPECT_NEAR(yawOf(Eigen::Quaterniond(filter.output()->map_T_base.linear())), 1.0, 2e-3);
  const Eigen::Isometry3d odom = filter.output()->odom_T_base;
  EXPECT_TRUE(filter.setPose(Pose2(-1.0, 2.0, -2.0), covariance));
  EXPECT_NEAR(filter.output()->map_T_base.translation().x(), -1.0, 1e-6);
  EXPECT_NEAR(filter.output()->covariance(kPosition, kPosition), 0.01, 1e-4);
  EXPECT_LT((filter.output()->odom_T_base.matrix() - odom.matrix()).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(PoseFilter, RestartsOnRequestWithoutAJumpInOdom) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 10.0;
  feed(flight, feeding, filter);
  const FilterOutput before = *filter.output();
  filter.restart();
  EXPECT_FALSE(filter.output());
  EXPECT_EQ(statusAtEnd(filter, flight, 10.0).health, FilterHealth::kInitializing);
  feeding.from_s = 10.0;
  feeding.until_s = 18.0;
  std::optional<FilterOutput> first;
  feeding.output = [&](double, const FilterOutput& output) {
    if (!first) first = output;
  };
  feed(flight, feeding, filter);
  EXPECT_LT((first->odom_T_base.translation() - before.odom_T_base.translation()).norm(), 1e-9);
  EXPECT_LT(errorsOf(flight, *filter.output()).position_m, 0.05);
  EXPECT_EQ(statusAtEnd(filter, flight, 18.0).resets.at("on request"), 1U);
}

TEST(PoseFilter, ReturnsStatesOfItsHistory) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 10.0;
  feed(flight, feeding, filter);
  const double stamp = flight.start_stamp + 9.503;
  const std::optional<FilterOutput> then = filter.at(stamp);
  ASSERT_TRUE(then);
  EXPECT_EQ(then->stamp, stamp);
  EXPECT_LT((then->map_T_base.translation() - flight.position(9.503)).norm(), 0.03);
  EXPECT_FALSE(filter.at(flight.start_stamp + 5.0));
  EXPECT_FALSE(filter.at(flight.start_stamp + 11.0));
  EXPECT_FALSE(filter.at(std::numeric_limits<double>::quiet_NaN()));
}

TEST(PoseFilter, RefusesAConfigurationOutsideOfItsLimits) {
  PoseFilterConfig config;
  config.gate.history_s = 0.0;
  EXPECT_THROW(PoseFilter{config}, std::invalid_argument);
  config = PoseFilterConfig();
  config.noise.gyro_noise = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(PoseFilter{config}, std::invalid_argument);
}

}  // namespace
}  // namespace kestrel
