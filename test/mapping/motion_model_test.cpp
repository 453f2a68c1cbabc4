// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/motion_model.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

constexpr double kClock = 1.7e9;  // s: a stamp of ROS
constexpr double kPeriod = 0.1, kSpeed = 2.5;

PlanarScan scanAt(double time) {
  PlanarScan scan;
  scan.stamp = scan.time = time;
  return scan;
}

/// A vehicle that flies along x. The laser measures at the periods from 0 on.
class Flight {
 public:
  void match(double period) { matchAt(kClock + kPeriod * period, kPeriod * period * kSpeed); }
  void matchAt(double time, double x) {
    const PlanarScan scan = scanAt(time);
    model_.move(Pose2(x, 0, 0), Pose2(x, 0, 0), false, scan);
    model_.remember(scan, std::nullopt, std::nullopt);
  }
  /// The first guess for the next scan, m.
  double predict(double period) const { return predictAt(kClock + kPeriod * period); }
  double predictAt(double time) const {
    return model_.request(Points(), scanAt(time), std::nullopt).initial_guesses.front().x;
  }
  std::optional<Pose2> motionPredictionAt(double time) const {
    const PlanarScan scan = scanAt(time);
    const Points points;
    return model_.motionPrediction(model_.request(points, scan, std::nullopt), scan, std::nullopt);
  }
  bool isOutOfReach(double period) const {
    return model_.isOutOfReach(scanAt(kClock + kPeriod * period), std::nullopt);
  }
  const MotionModel& model() const { return model_; }

 private:
  MotionModel model_{MapperConfig()};
};

TEST(MotionModel, AGapIsSeenFromTheThirdScanOn) {
  Flight flight;
  flight.match(0);
  flight.match(1);
  EXPECT_FALSE(flight.model().isGap(4 * kPeriod));
  EXPECT_TRUE(flight.model().isGap(6 * kPeriod));
}

TEST(MotionModel, AGapBeforeTheSecondScanDoesNotHideTheNextOne) {
  Flight flight;
  flight.match(0);
  flight.match(30);
  flight.match(31);
  EXPECT_TRUE(flight.model().isGap(6 * kPeriod));
}

TEST(MotionModel, MissingScansDoNotChangeThePredictedSpeed) {
  Flight flight;
  for (int i = 0; i < 6; ++i) flight.match(i);
  EXPECT_NEAR(flight.predict(6), 6 * kPeriod * kSpeed, 1e-6);
  EXPECT_NEAR(flight.predict(8), 8 * kPeriod * kSpeed, 1e-6);
  flight.match(8);
  EXPECT_NEAR(flight.predict(9), 9 * kPeriod * kSpeed, 1e-6);
}

TEST(MotionModel, TwoScansThatAreDeliveredAtOnceDoNotChangeThePredictedMotion) {
  Flight flight;
  constexpr double kStep = kPeriod * kSpeed, kSoon = 0.01;
  for (int i = 0; i < 4; ++i) flight.match(i);
  for (int i = 4; i < 12; i += 2) {
    flight.matchAt(kClock + kPeriod * i, kStep * i);
    EXPECT_NEAR(flight.predictAt(kClock + kPeriod * i + kSoon), kStep * (i + 1), 1e-3);
    flight.matchAt(kClock + kPeriod * i + kSoon, kStep * (i + 1));
  }
}

TEST(MotionModel, AScanPerMeterIsAStepOfOneMeterWhateverTheTime) {
  Flight flight;
  double time = kClock;
  for (int i = 0; i < 12; ++i) {
    time += i % 3 == 0 ? 1.0 : 2.2;
    if (i > 6) {
      EXPECT_NEAR(flight.predictAt(time), i, 1e-3) << i;
    }
    flight.matchAt(time, i);
  }
}

constexpr double kRarePeriod = 2.1, kRareStep = 1.1;  // s, m: recorded once a meter

/// The time and the place of scan `i` of a recording with a scan per meter.
double rareTime(int i) { return kClock + kRarePeriod * i; }
Flight flightWithRareScans() {
  Flight flight;
  for (int i = 0; i < 4; ++i) flight.matchAt(rareTime(i), kRareStep * i);
  return flight;
}

TEST(MotionModel, AStepOfMoreThanAMeterGoesOnWhereScansAreRare) {
  EXPECT_NEAR(flightWithRareScans().predictAt(rareTime(4)), 4 * kRareStep, 1e-3);
}

TEST(MotionModel, AnOdometryMeasuresALongStepWhichIsNotGuessed) {
  MotionModel model{MapperConfig()};
  const auto at = [](int i) { return Pose2(kRareStep * i, 0, 0); };
  for (int i = 0; i < 4; ++i) {
    model.move(at(i), at(i), false, scanAt(rareTime(i)));
    model.remember(scanAt(rareTime(i)), at(i), std::nullopt);
  }
  const std::vector<Pose2> guesses =
      model.request(Points(), scanAt(rareTime(4)), at(4)).initial_guesses;
  ASSERT_GE(guesses.size(), 2U);
  EXPECT_NEAR(guesses[0].x, at(4).x, 1e-3);
  EXPECT_NEAR(guesses[1].x, at(3).x, 1e-3);
}

TEST(MotionModel, AJumpOfMoreThanAMeterDoesNotGoOnWhereScansAreFrequent) {
  Flight flight;
  for (int i = 0; i < 6; ++i) flight.match(i);
  const double jumped = 5 * kPeriod * kSpeed + kRareStep;
  flight.matchAt(kClock + 6 * kPeriod, jumped);
  EXPECT_NEAR(flight.predict(7), jumped, 1e-6);
}

TEST(MotionModel, TheMotionGoesOnAlongACorridorWhereScansAreRare) {
  const Flight flight = flightWithRareScans();
  const std::optional<Pose2> next = flight.motionPredictionAt(rareTime(4));
  ASSERT_TRUE(next);
  EXPECT_NEAR(next->x, 4 * kRareStep, 1e-3);
  EXPECT_NEAR(flight.model().secondsSince(scanAt(rareTime(4))), kRarePeriod, 1e-6);
  EXPECT_FALSE(flight.motionPredictionAt(rareTime(40)));
}

TEST(MotionModel, AVehicleMayTurnBackBetweenRareScans) {
  const auto turnedBack = [](const Flight& flight, double time) {
    return flight.model().request(Points(), scanAt(time), std::nullopt).turned_back_m;
  };
  EXPECT_NEAR(turnedBack(flightWithRareScans(), rareTime(4)), 2 * kRareStep, 1e-3);
  Flight frequent;
  for (int i = 0; i < 6; ++i) frequent.match(i);
  EXPECT_EQ(turnedBack(frequent, kClock + 6 * kPeriod), 0.0);
}

TEST(MotionModel, ThePoseIsNearTheGuessWhereScansAreFrequent) {
  const auto isNear = [](const Flight& flight, double time) {
    return flight.model().request(Points(), scanAt(time), std::nullopt).near;
  };
  Flight frequent;
  for (int i = 0; i < 6; ++i) frequent.match(i);
  EXPECT_TRUE(isNear(frequent, kClock + 6 * kPeriod));
  EXPECT_FALSE(isNear(frequent, kClock + 30 * kPeriod));
  EXPECT_FALSE(isNear(flightWithRareScans(), rareTime(4)));
}

TEST(MotionModel, AfterALongGapTheVehicleMayBeAnywhere) {
  Flight flight;
  for (int i = 0; i < 6; ++i) flight.match(i);
  EXPECT_FALSE(flight.isOutOfReach(8));
  EXPECT_FALSE(flight.isOutOfReach(13));
  EXPECT_TRUE(flight.isOutOfReach(40));
}

}  // namespace
}  // namespace kestrel
