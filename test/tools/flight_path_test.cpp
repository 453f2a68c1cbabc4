#include "kestrel_slam/tools/flight_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/tools/simulator.h"

namespace kestrel_slam {
namespace {

constexpr double kStep = 1e-3;  // s

FlightPath squareFlight() {
  return FlightPath({{0.0, 0.0}, {4.0, 0.0}, {4.0, 4.0}, {0.0, 4.0}}, 0.5);
}

double speedAt(const FlightPath& path, double time) {
  return (path.at(time + kStep).translation() - path.at(time - kStep).translation()).norm() /
         (2.0 * kStep);
}

TEST(FlightPath, passesTheKnownPointsOfTheSpline) {
  // A uniform cubic B-spline passes (1·a + 4·b + 1·c) / 6 at each control point b.
  const Pose2 start = squareFlight().at(0.0);
  EXPECT_NEAR(start.x, (0.0 + 4.0 * 4.0 + 4.0) / 6.0, 1e-12);
  EXPECT_NEAR(start.y, (0.0 + 4.0 * 0.0 + 4.0) / 6.0, 1e-12);
  EXPECT_NEAR(start.theta, kPi / 4.0, 1e-12);  // along c - a
}

TEST(FlightPath, closesAndHoversAtBothEnds) {
  const FlightPath path = squareFlight();
  const Pose2 start = path.at(0.0);
  for (const double time : {-5.0, 0.5, 1.0, path.duration() - 0.5, path.duration() + 100.0}) {
    const Pose2 difference = start.inverse() * path.at(time);
    EXPECT_LT(difference.distance(), 1e-9) << time;
    EXPECT_NEAR(difference.theta, 0.0, 1e-9) << time;
  }
}

TEST(FlightPath, fliesAtTheGivenSpeedAfterTheRamp) {
  const FlightPath path = squareFlight();
  EXPECT_NEAR(speedAt(path, 2.0), 0.25, 1e-3);  // half way up the ramp of 2 s after 1 s of hover
  for (double time = 3.1; time < path.duration() - 3.1; time += 0.37) {
    EXPECT_NEAR(speedAt(path, time), 0.5, 1e-3) << time;
  }
}

TEST(FlightPath, lengthIsTheDistanceFlown) {
  const FlightPath path = squareFlight();
  double flown = 0.0;
  for (double time = 0.0; time < path.duration(); time += 0.01) {
    flown += (path.at(time + 0.01).translation() - path.at(time).translation()).norm();
  }
  EXPECT_NEAR(flown, path.length(), 1e-3);
  EXPECT_NEAR(path.duration(), 4.0 + path.length() / 0.5, 1e-12);
}

TEST(FlightPath, turnsSmoothly) {
  for (const SimulatedWorld& world : simulatedWorlds()) {
    const FlightPath path = world.flight();
    double last_rate = 0.0;
    for (double time = 0.0; time < path.duration(); time += 0.01) {
      const double rate = normalizeAngle(path.at(time + kStep).theta - path.at(time).theta) / kStep;
      EXPECT_LT(std::abs(rate), 2.0) << world.name << " " << time;
      EXPECT_LT(std::abs(rate - last_rate), 0.2) << world.name << " " << time;
      last_rate = rate;
    }
  }
}

TEST(FlightPath, refusesWhatIsNoFlight) {
  EXPECT_THROW(FlightPath({{0.0, 0.0}, {1.0, 0.0}}, 1.0), std::invalid_argument);
  EXPECT_THROW(FlightPath({{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}, 0.0), std::invalid_argument);
  EXPECT_THROW(
      FlightPath({{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}, std::numeric_limits<double>::quiet_NaN()),
      std::invalid_argument);
}

}  // namespace
}  // namespace kestrel_slam
