// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/drive_measurement.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kestrel {
namespace {

TEST(DriveMeasurement, BeginOfTheDriveIsMappedWithBothLasers) {
  constexpr std::size_t kWaypoints = 8;
  FlightTrial trial = townDrive();
  trial.place.plan.waypoints.resize(kWaypoints);
  const DriveMeasurement m = measureDrive(trial);
  const double seconds = m.flight.run.duration_s;
  const auto scans = static_cast<double>(m.flight.run.scans.size());
  EXPECT_NEAR(scans / seconds, 2.0 * trial.vehicle.laser->rate_hz, 0.5);
  EXPECT_EQ(m.flight.lost, 0U);
  EXPECT_NEAR(m.length_m, 54.0, 3.0);
  EXPECT_LT(m.flight.error.ate_statistics.translation_m.rmse, 0.12);
  EXPECT_LT(m.end_error_m, 0.3);
  EXPECT_GT(m.area_m2, 2000.0);
  EXPECT_GT(m.quarters[0].map_mb, 0.0);
  for (const DriveQuarter& quarter : m.quarters) EXPECT_GT(quarter.median_ms, 0.0);
  EXPECT_EQ(m.quarters[3].map_mb * 1e6, static_cast<double>(m.flight.run.map_memory_bytes));
}

TEST(DriveMeasurement, DriveHasTheLengthOfThePaper) {
  const FlightTrial trial = townDrive();
  double length = 0.0;
  const auto& points = trial.place.plan.waypoints;
  for (std::size_t i = 1; i < points.size(); ++i) {
    length += (points[i].position - points[i - 1].position).norm();
  }
  EXPECT_NEAR(length, 1200.0, 1.0);
  EXPECT_EQ(trial.vehicle.laser->range_max, 200.0);
  EXPECT_EQ(trial.vehicle.second_laser->range_max, 200.0);
  EXPECT_FALSE(trial.vehicle.imu);
}

}  // namespace
}  // namespace kestrel
