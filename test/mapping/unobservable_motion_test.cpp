// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/mapping/unobservable_motion.h"

#include <gtest/gtest.h>

#include "room.h"

namespace kestrel {
namespace {

constexpr double kSigmaM = 0.05;

/// A match in a corridor with `obstacles`, and whether it was found to be unclear.
MatchResult checked(const std::vector<room::Segment>& obstacles, double away_m,
                    double sigma_m = kSigmaM) {
  std::vector<room::Segment> walls = room::corridor();
  walls.insert(walls.end(), obstacles.begin(), obstacles.end());
  Submap map{OccupancyGridConfig()};
  const PlanarScan scan = room::scanFrom(Pose2(), walls, 360, 20.0);
  map.insert(scan, Pose2());
  MatchResult match;
  match.degenerate_direction = Eigen::Vector2d::UnitX();
  match.covariance.setIdentity();
  checkAlong(map, hitsOf(scan), away_m, sigma_m, match);
  return match;
}

const std::vector<room::Segment> kEnd = {{1.5, -1.0, 1.5, 1.0}};
const std::vector<room::Segment> kPole = {{3.0, -0.1, 3.0, 0.1}};

TEST(UnobservableMotion, AMatchThatFewBeamsShowAndThatIsNotExpectedIsUnclear) {
  EXPECT_TRUE(checked(kPole, 0.3).unclear_along);
  EXPECT_TRUE(checked(kPole, -0.3).unclear_along);
  EXPECT_FALSE(checked(kEnd, 0.3).unclear_along);
}

TEST(UnobservableMotion, AMatchNearThePredictionIsClear) {
  EXPECT_FALSE(checked(kPole, 0.03).unclear_along);
  EXPECT_FALSE(checked(kPole, 0.3, 0.5).unclear_along);
}

TEST(UnobservableMotion, AnUnclearMatchIsUncertainAlongTheDirection) {
  const MatchResult match = checked({}, 0.3);  // nothing shows which of the two is right
  EXPECT_NEAR(match.covariance(0, 0), 1.0 + 0.5 * 0.3 * 0.3, 0.01);
  EXPECT_DOUBLE_EQ(match.covariance(1, 1), 1.0);
}

}  // namespace
}  // namespace kestrel
