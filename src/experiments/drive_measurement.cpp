// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/drive_measurement.h"

#include <cmath>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/offline/stats.h"

namespace kestrel {
namespace {

constexpr double kBytesPerMegabyte = 1e6;

DriveQuarter quarterOf(const std::vector<ScanRecord>& scans, std::size_t first, std::size_t end) {
  std::vector<double> ms;
  for (std::size_t i = first; i < end; ++i) ms.push_back(scans[i].ms);
  DriveQuarter quarter;
  quarter.median_ms = statisticsOf(ms).median;
  if (end > first) {
    quarter.map_mb = static_cast<double>(scans[end - 1].map_bytes) / kBytesPerMegabyte;
  }
  return quarter;
}

/// The place with a level motion without wind, as of a ground vehicle.
Place levelPlace(const std::string& name) {
  Place result = place(name);
  result.quadrotor.level = true;
  result.quadrotor.gust_m_s2 = 0.0;
  return result;
}

}  // namespace

FlightTrial townDrive() {
  const LaserModel& scanner = laserModel("alasca");
  FlightTrial trial;
  trial.name = "drive of 1.2 km";
  trial.place = levelPlace("town");
  trial.vehicle.laser = trial.vehicle.second_laser = scanner;
  // Mounted at the front corners and rotated outwards, so that together they see 360 degrees.
  const Eigen::Translation3d left(1.0, 0.6, 0.0), right(1.0, -0.6, 0.0);  // m
  const double outward = degToRad(60.0);
  trial.vehicle.base_T_laser = left * Eigen::AngleAxisd(outward, Eigen::Vector3d::UnitZ());
  trial.vehicle.base_T_second_laser = right * Eigen::AngleAxisd(-outward, Eigen::Vector3d::UnitZ());
  trial.vehicle.imu.reset();
  trial.vehicle.range_finder.reset();
  trial.config.projector.beams.max_range_m = scanner.range_max;
  return trial;
}

FlightTrial largeTownDrive() {
  FlightTrial trial = townDrive();
  trial.name = "drive of 2.4 km";
  trial.place = levelPlace("large_town");
  return trial;
}

FlightTrial sparseTownDrive() {
  FlightTrial trial = townDrive();
  trial.name = "drive with gaps of 50 m";
  trial.place = levelPlace("sparse_town");
  return trial;
}

DriveMeasurement measureDrive(const FlightTrial& trial) {
  DriveMeasurement result;
  result.flight = measureFlight(trial);
  const ReferenceEvaluation& error = result.flight.error;
  result.length_m = pathLength(error.reference);
  const auto motionOf = [](const Trajectory& path) {
    return path.front().pose.inverse() * path.back().pose;
  };
  const Pose2 end = motionOf(error.reference).inverse() * motionOf(error.aligned);
  result.end_error_m = end.distance();
  result.end_error_deg = std::abs(radToDeg(end.yaw));
  result.area_m2 = knownArea(result.flight.run.map);
  const std::vector<ScanRecord>& scans = result.flight.run.scans;
  for (std::size_t i = 0; i < result.quarters.size(); ++i) {
    const std::size_t count = result.quarters.size();
    result.quarters[i] = quarterOf(scans, i * scans.size() / count, (i + 1) * scans.size() / count);
  }
  return result;
}

}  // namespace kestrel
