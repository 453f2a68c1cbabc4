// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/drive_measurement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

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
  EXPECT_DOUBLE_EQ(m.quarters[3].map_mb * 1e6, static_cast<double>(m.flight.run.map_memory_bytes));
}

/// The first scans of a drive: a part of a straight road and of a turn.
FlightMeasurement beginOf(FlightTrial trial) {
  trial.options.max_scans = 1100;
  return measureFlight(trial);
}

double shareOf(MatchState state, const std::vector<ScanRecord>& scans) {
  const auto count = std::count_if(scans.begin(), scans.end(),
                                   [&](const ScanRecord& scan) { return scan.state == state; });
  return static_cast<double>(count) / static_cast<double>(scans.size());
}

TEST(DriveMeasurement, TwoLasersAgreeOnAStraightRoadAndInATurn) {
  const FlightMeasurement m = beginOf(townDrive());
  EXPECT_GT(shareOf(MatchState::kOk, m.run.scans), 0.85);
  EXPECT_EQ(m.lost, 0U);
  const Trajectory &found = m.error.aligned, &truth = m.error.reference;
  double worst = 0.0;
  for (std::size_t i = 1; i < found.size(); ++i) {
    const Pose2 step = found[i - 1].pose.between(found[i].pose);
    worst = std::max(worst, truth[i - 1].pose.between(truth[i].pose).between(step).distance());
  }
  EXPECT_LT(worst, 0.12);  // m, from a scan of one laser to the next one of the other
}

TEST(DriveMeasurement, TheSecondLaserIsInTheMapFromTheBeginning) {
  FlightTrial trial = sparseTownDrive();
  trial.options.max_scans = 40;  // the vehicle stands most of the time
  const FlightMeasurement m = measureFlight(trial);
  EXPECT_EQ(m.lost, 0U);
  for (std::size_t i = 3; i < m.run.scans.size(); ++i) EXPECT_GT(m.run.scans[i].known, 0.5) << i;
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
