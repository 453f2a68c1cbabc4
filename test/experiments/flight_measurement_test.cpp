// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/flight_measurement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "temporary_folder.h"

namespace kestrel {
namespace {

FlightTrial shortFlight(const std::string& name) {
  constexpr double kDuration = 6.0;  // s
  FlightTrial trial;
  trial.place = place(name);
  trial.vehicle = quadrotorWith("utm30lx");
  trial.place.plan = randomPlan(trial.place, kDuration, trial.seed);
  return trial;
}

TEST(FlightMeasurement, DistanceToUprightSurfaces) {
  World::Parts parts;
  parts.boxes.push_back({{2.0, 0.0, 0.5}, {1.0, 2.0, 1.0}});
  parts.cylinders.push_back({{-3.0, 0.0}, 0.5});
  EXPECT_NEAR(distanceToUprightSurface(parts, {1.0, 0.0}), 0.5, 1e-12);
  EXPECT_NEAR(distanceToUprightSurface(parts, {2.0, 0.0}), 0.5, 1e-12)
      << "in the middle of a table";
  EXPECT_NEAR(distanceToUprightSurface(parts, {-3.0, 1.0}), 0.5, 1e-12);
}

TEST(FlightMeasurement, FlightsAreMappedToMillimetersAndRepeatably) {
  const FlightTrial trial = shortFlight("laboratory");
  const FlightMeasurement first = measureFlight(trial), second = measureFlight(trial);
  EXPECT_EQ(first.lost, 0U);
  EXPECT_GT(first.run.scans.size(), 200U);
  EXPECT_LT(first.error.ate_statistics.translation_m.rmse, 0.01);
  EXPECT_LT(first.error.ate_statistics.rotation_deg.rmse, 0.3);
  EXPECT_LT(first.false_cells, first.occupied_cells / 200);
  ASSERT_EQ(first.run.trajectory.size(), second.run.trajectory.size());
  for (std::size_t i = 0; i < first.run.trajectory.size(); ++i) {
    ASSERT_EQ(first.run.trajectory[i].pose, second.run.trajectory[i].pose) << i;
  }
}

/// Number of free cells of the map outside of the building.
int freeCellsOutside(const FlightTrial& trial, const FlightMeasurement& flight) {
  constexpr double kTolerance = 0.1;  // m
  Eigen::AlignedBox2d building;
  for (const Box& box : trial.place.parts.boxes) {
    const Eigen::Vector2d size =
        Eigen::Rotation2Dd(box.yaw).toRotationMatrix().cwiseAbs() * box.size.head<2>();
    building.extend(box.center.head<2>() - 0.5 * size);
    building.extend(box.center.head<2>() + 0.5 * size);
  }
  const MapSnapshot& map = flight.run.map;
  int outside = 0;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      const Eigen::Vector2d in_map(map.origin_x + (column + 0.5) * map.resolution_m,
                                   map.origin_y + (row + 0.5) * map.resolution_m);
      const double distance =
          building.exteriorDistance(Eigen::Vector2d(flight.error.reference_T_map * in_map));
      outside += map.at(column, row) == MapSnapshot::kFree && distance > kTolerance ? 1 : 0;
    }
  }
  return outside;
}

TEST(FlightMeasurement, GlassAndBlackWallsDoNotOpenSpaceOutsideOfTheBuilding) {
  for (const char* name : {"glass", "laboratory"}) {
    FlightTrial trial = shortFlight(name);
    trial.place.plan = randomPlan(trial.place, 20.0, trial.seed);
    const FlightMeasurement flight = measureFlight(trial);
    EXPECT_EQ(flight.lost, 0U) << name;
    EXPECT_EQ(freeCellsOutside(trial, flight), 0) << name;
  }
}

TEST(FlightMeasurement, WithoutTheProjectorTheFloorAppearsAsWalls) {
  FlightTrial trial = shortFlight("laboratory");
  trial.place.plan.speed_m_s = 2.0;
  trial.place.plan.acceleration_m_s2 = 3.0;
  trial.place.plan.smooth = false;
  const FlightMeasurement with = measureFlight(trial);
  trial.options.use_imu = false;
  const FlightMeasurement without = measureFlight(trial);
  EXPECT_GT(with.max_tilt_deg, 12.0);
  EXPECT_LT(with.error.ate_statistics.translation_m.rmse,
            0.5 * without.error.ate_statistics.translation_m.rmse);
  EXPECT_LT(with.false_cells, without.false_cells);
}

}  // namespace
}  // namespace kestrel
