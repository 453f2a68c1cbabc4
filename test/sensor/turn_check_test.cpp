// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/turn_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/scan_turn.h"
#include "room_log.h"

namespace kestrel {
namespace {

/// A scan in the room at (x, 0) in the direction `yaw`.
LaserScan scanAt(double x, double yaw) {
  LaserScan scan = RoomFlight::scan(0);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = scan.angle_min + scan.angle_increment * static_cast<double>(i);
    scan.ranges[i] = static_cast<float>(RoomFlight::range(x, yaw + angle));
  }
  return scan;
}

TEST(ScanTurn, IsMeasuredToADegree) {
  for (const double turn : {-0.6, -0.1, 0.0, 0.03, 0.4, 0.8}) {
    const auto found =
        turnBetween(rangesAround(scanAt(0.0, 0.2)), rangesAround(scanAt(0.1, 0.2 + turn)));
    ASSERT_TRUE(found) << turn;
    EXPECT_NEAR(*found, turn, degToRad(1.5)) << turn;
  }
}

TEST(ScanTurn, OfReversedAnglesIsTheSame) {
  const auto reversed = [](LaserScan scan) {
    scan.angle_min += scan.angle_increment * static_cast<double>(scan.ranges.size() - 1);
    scan.angle_increment = -scan.angle_increment;
    std::reverse(scan.ranges.begin(), scan.ranges.end());
    return scan;
  };
  const auto found = turnBetween(rangesAround(reversed(scanAt(0.0, 0.0))),
                                 rangesAround(reversed(scanAt(0.0, 0.3))));
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, 0.3, degToRad(1.0));
}

TEST(ScanTurn, IsUnknownInARoundRoomAndWithoutReturns) {
  LaserScan round = RoomFlight::scan(0);
  round.ranges.assign(round.ranges.size(), 3.0F);
  EXPECT_FALSE(turnBetween(rangesAround(round), rangesAround(round)));
  round.ranges.assign(round.ranges.size(), std::numeric_limits<float>::infinity());
  EXPECT_FALSE(turnBetween(rangesAround(round), rangesAround(round)));
  round.ranges.clear();
  EXPECT_FALSE(turnBetween(rangesAround(round), rangesAround(round)));
}

/// Yaw of a vehicle that turns to both sides.
double yawAt(double time) { return 0.8 * std::sin(0.7 * time) + 0.3 * std::sin(1.9 * time); }

/// Feeds 20 s of turns with noise, as they are measured by scans.
TurnCheck checked(const std::function<double(double)>& other) {
  TurnCheck check;
  Random random(1);
  for (double t = 0.0; t < 20.0; t += 0.2) {
    check.add(t, t + 0.2, yawAt(t + 0.2) - yawAt(t) + degToRad(0.5) * random.gaussian());
    check.compare(t + 0.2, [&](double time) -> std::optional<double> {
      if (time > t + 0.2) return std::nullopt;
      return other(time);
    });
  }
  return check;
}

TEST(TurnCheck, AgreesWithTheSameTurn) {
  const TurnCheck check = checked([](double t) { return yawAt(t) + 0.01 * t; });
  EXPECT_EQ(check.verdict(), RotationVerdict::kAgree);
  EXPECT_FALSE(check.delay());
}

TEST(TurnCheck, FindsOppositeTurnsDegreesAndZero) {
  EXPECT_EQ(checked([](double t) { return -yawAt(t); }).verdict(), RotationVerdict::kOpposite);
  EXPECT_EQ(checked([](double t) { return radToDeg(yawAt(t)); }).verdict(),
            RotationVerdict::kDegrees);
  EXPECT_EQ(checked([](double t) { return 0.001 * t; }).verdict(), RotationVerdict::kFirstZero);
}

TEST(TurnCheck, FindsADelay) {
  for (const double delay : {-0.25, 0.25}) {
    const TurnCheck check = checked([&](double t) { return yawAt(t - delay); });
    EXPECT_EQ(check.verdict(), RotationVerdict::kAgree);
    ASSERT_TRUE(check.delay());
    EXPECT_NEAR(*check.delay(), delay, 0.051);
  }
}

TEST(TurnCheck, ASmallDelayIsNotSaid) {
  EXPECT_FALSE(checked([](double t) { return yawAt(t - 0.05); }).delay());
}

TEST(TurnCheck, AStraightFlightGivesNoVerdict) {
  TurnCheck check;
  Random random(2);
  for (double t = 0.0; t < 60.0; t += 0.2) {
    check.add(t, t + 0.2, degToRad(1.0) * random.gaussian());
    check.compare(t + 0.2, [](double) { return 0.0; });
  }
  EXPECT_EQ(check.verdict(), RotationVerdict::kUnknown);
}

}  // namespace
}  // namespace kestrel
