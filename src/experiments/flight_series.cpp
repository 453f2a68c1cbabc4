// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/flight_series.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kestrel_slam/experiments/drive_measurement.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/offline/stats.h"

namespace kestrel {
namespace {

constexpr double kRandomFlight_s = 30.0;

/// A random flight in one of the places where the laser constrains every direction.
FlightTrial randomFlight(std::uint64_t seed) {
  static const std::array<const char*, 6> kPlaces = {"laboratory", "ring",   "cluttered",
                                                     "glass",      "people", "doors"};
  FlightTrial trial = flightIn("random flights of 30 s", kPlaces[seed % kPlaces.size()]);
  trial.seed = seed;
  trial.place.plan = randomPlan(trial.place, kRandomFlight_s, seed);
  return trial;
}

FlightSeries seriesOf(const FlightTrial& trial) {
  return {trial.name, [trial](std::uint64_t seed) {
            FlightTrial result = trial;
            result.seed = seed;
            return result;
          }};
}

/// A part of the standard path of a place with turns on the spot.
FlightPlan fastTurnPlan(const FlightPlan& path, Random& random) {
  constexpr std::size_t kPoints = 16;
  constexpr double kSlowest = degToRad(60.0), kFastest = degToRad(300.0);   // rad/s
  constexpr double kSmallest = degToRad(60.0), kLargest = degToRad(180.0);  // rad
  constexpr double kTurnProbability = 0.35;                                 // at a waypoint
  FlightPlan plan = path;
  plan.nose_forward = false;
  plan.yaw_rate_rad_s = random.uniform(kSlowest, kFastest);
  const std::size_t count = std::min(kPoints, path.waypoints.size());
  const auto choices = static_cast<double>(path.waypoints.size() - count + 1);
  const auto first = static_cast<std::size_t>(random.uniform() * choices);
  double yaw = random.uniform(-kPi, kPi);
  plan.waypoints.clear();
  for (std::size_t i = first; i < first + count; ++i) {
    FlightPlan::Waypoint waypoint = path.waypoints[i];
    waypoint.hover_s = 0.0;
    waypoint.yaw = yaw;
    plan.waypoints.push_back(waypoint);
    if (i == first || random.uniform() > kTurnProbability) continue;
    const double turn = random.uniform(kSmallest, kLargest);
    yaw += random.uniform() < 0.5 ? turn : -turn;
    waypoint.yaw = yaw;
    plan.waypoints.push_back(waypoint);  // the same place: a turn on the spot
  }
  return plan;
}

void countSilentJumps(const FlightMeasurement& flight, SeedResult& result) {
  const Trajectory &found = flight.error.aligned, &truth = flight.error.reference;
  for (std::size_t i = 1; i < found.size(); ++i) {
    const auto is_ok = [&](std::size_t k) { return flight.run.scans[k].state == MatchState::kOk; };
    if (!is_ok(i - 1) || !is_ok(i)) continue;
    const Pose2 motion = found[i - 1].pose.between(found[i].pose);
    const double jump = truth[i - 1].pose.between(truth[i].pose).between(motion).distance();
    result.largest_silent_jump_m = std::max(result.largest_silent_jump_m, jump);
    if (jump > kSilentJump) ++result.silent_jumps;
  }
}

void countWrongScans(const FlightMeasurement& flight, SeedResult& result) {
  const Trajectory &found = flight.error.aligned, &truth = flight.error.reference;
  for (std::size_t i = 1; i < found.size(); ++i) {
    const Pose2 error = truth.front()
                            .pose.between(truth[i].pose)
                            .between(found.front().pose.between(found[i].pose));
    const bool is_wrong =
        error.distance() > kWrongPose || std::abs(radToDeg(error.yaw)) > kWrongYawDeg;
    if (!is_wrong || flight.run.scans[i].state != MatchState::kOk) continue;
    if (result.wrong_and_ok++ == 0) result.first_wrong = i;
  }
}

}  // namespace

FlightTrial fastTurnDrive(std::uint64_t seed) {
  static const std::array<const char*, 3> kBuildings = {"laboratory", "ring", "doors"};
  constexpr double kTurnAcceleration = 20.0;  // rad/s², reaches 300°/s within 50°
  Random random(seed);
  FlightTrial trial = flightIn("fast turns, SICK at 5 Hz", kBuildings[seed % kBuildings.size()]);
  trial.seed = seed;
  trial.vehicle.laser = laserModel("sick180");
  trial.vehicle.imu.reset();
  trial.vehicle.range_finder.reset();
  trial.place.quadrotor.level = true;
  trial.place.quadrotor.gust_m_s2 = 0.0;
  trial.place.quadrotor.yaw_acceleration_rad_s2 = kTurnAcceleration;
  trial.place.plan = fastTurnPlan(trial.place.plan, random);
  return trial;
}

std::vector<FlightSeries> flightSeries() {
  std::vector<FlightSeries> series;
  for (const FlightTrial& trial : standardFlights()) series.push_back(seriesOf(trial));
  series.push_back(seriesOf(flightIn("twin corridors with identical rooms", "twins")));
  series.push_back({"random flights of 30 s", randomFlight});
  series.push_back({"fast turns, SICK at 5 Hz", fastTurnDrive});
  for (const FlightTrial& trial : {townDrive(), largeTownDrive(), sparseTownDrive()}) {
    series.push_back(seriesOf(trial));
  }
  return series;
}

SeedResult resultOf(const FlightMeasurement& flight) {
  constexpr double kQuarter = 0.25;
  SeedResult result;
  result.scans = flight.run.scans.size();
  const MatchSummary states = summarize(flight.run.scans);
  result.lost = states.lost;
  result.degraded = states.degraded;
  result.ate_m = flight.error.ate_statistics.translation_m.rmse;
  result.worst_m = flight.error.ate_statistics.translation_m.max;
  // Every simulated scan has a true pose, so `error.aligned` has one pose for each scan.
  countSilentJumps(flight, result);
  countWrongScans(flight, result);
  result.worst_long_m = flight.consistency.worst_long_m;
  result.worst_long_sigmas = flight.consistency.worst_long_sigmas;
  result.worst_short_m = flight.consistency.worst_short_m;
  result.first_quarter_ms = scanTimes(flight.run, 0.0, kQuarter).median;
  result.last_quarter_ms = scanTimes(flight.run, 1.0 - kQuarter, 1.0).median;
  result.area_m2 = knownArea(flight.run.map);
  if (flight.run.graph) result.loops = qualityOf(*flight.run.graph, flight.error.reference);
  return result;
}

}  // namespace kestrel
