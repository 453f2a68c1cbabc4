// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/polish.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/loop_world.h"
#include "kestrel_slam/offline/graph_result.h"

namespace kestrel {
namespace {

struct Flight {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  Polish polish{MapperConfig()};
  std::vector<Pose2> truths = loop_world::laps(0.5);
  Trajectory noisy;  ///< wrong by some centimeters, in turn to one side and the other

  Flight() {
    loop_world::Drive drive(loop_world::ring(), 0.0, truths[0]);
    for (std::size_t i = 0; i < truths.size(); ++i) {
      drive.add(truths[i], graph);
      polish.keep(room::scanFrom(truths[i], loop_world::ring(), 180));
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      noisy.push_back(
          {0.1 * static_cast<double>(i + 1), truths[i] * Pose2(0.04 * side, 0.03, 0.0)});
    }
  }

  double error(const Trajectory& trajectory) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < truths.size(); ++i)
      sum += truths[i].between(trajectory[i].pose).distance();
    return sum / static_cast<double>(truths.size());
  }
};

TEST(Polish, MovesScansToTheWallsOfTheFinishedMap) {
  Flight flight;
  const Trajectory polished = flight.polish.polished(flight.noisy, flight.graph);
  EXPECT_NEAR(flight.error(flight.noisy), 0.05, 1e-9);
  EXPECT_LT(flight.error(polished), 0.02);
  EXPECT_GT(flight.polish.matchedCount(), flight.truths.size() * 8 / 10);
}

TEST(Polish, AScanThatIsFarFromItsPlaceStays) {
  Flight flight;
  for (StampedPose& pose : flight.noisy) pose.pose = pose.pose * Pose2(0.0, 0.0, 0.4);
  EXPECT_EQ(flight.polish.polished(flight.noisy, flight.graph)[30].pose, flight.noisy[30].pose);
}

TEST(MapAlong, DrawsTheKeyframesAtThePosesOfTheTrajectory) {
  const Flight flight;
  Trajectory moved = flight.noisy;
  for (std::size_t i = 0; i < moved.size(); ++i)
    moved[i].pose = Pose2(100.0, 0.0, 0.0) * flight.truths[i];
  const MapSnapshot there = mapAlong(moved, flight.graph, OccupancyGridConfig());
  const MapSnapshot here = mapOf(flight.graph, OccupancyGridConfig());
  EXPECT_NEAR(there.origin_x - here.origin_x, 100.0, 0.1);
  EXPECT_EQ(there.width, here.width);
}

}  // namespace
}  // namespace kestrel
