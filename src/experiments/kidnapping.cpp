// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/kidnapping.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/session/finished_map.h"
#include "kestrel_slam/session/graph_session.h"

namespace kestrel {
namespace {

/// A pose may be wrong for so long after the laser sees again, s.
constexpr double kNoticeS = 1.0;
/// Waypoints before and after the vehicle is carried. They are up to 0.7 m apart.
constexpr std::size_t kBeforeWaypoints = 3, kAfterWaypoints = 8;
/// The vehicle hovers where it is taken and where it is put down, s.
constexpr double kHoverS = 0.5;
/// The laser is covered from and to this distance from there, m.
constexpr double kCoverM = 0.3;
/// What covers the laser is so near, or the laser has no returns, m.
constexpr double kCoverRangeM = 0.3;
constexpr double kMotionStepS = 0.05;

VehicleModel vehicleOf() {
  constexpr double kRate = 10.0;  // Hz: enough for a slow flight
  VehicleModel model = quadrotorWith("utm30lx");
  model.laser->rate_hz = kRate;
  return model;
}

SlamConfig kidnapConfig() {
  SlamConfig config;
  config.mapper.window.enabled = true;
  return config;
}

/// From when to when the vehicle is away from both places.
BlockedView coverOf(const Motion& motion, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const auto awayFrom = [&](double time, const Eigen::Vector2d& place) {
    return (motion.at(time).world_T_base.translation().head<2>() - place).norm();
  };
  BlockedView cover;
  double time = 0.0;
  while (time < motion.duration() && awayFrom(time, to) > kCoverM) {
    if (awayFrom(time, from) < kCoverM) cover.from_s = time;
    time += kMotionStepS;
  }
  cover.until_s = time;
  return cover;
}

}  // namespace

bool KidnapTrial::add(double seconds, bool lost, double error_m) {
  if (lost) {
    if (!noticed) noticed_s = seconds;
    noticed = true;
    return false;
  }
  if (error_m < kWrongPoseM) return found = noticed = true;
  if (seconds > kNoticeS) wrong = true;
  return false;
}

void KidnapSummary::add(const KidnapTrial& trial) {
  ++trials;
  noticed += trial.noticed && !trial.wrong ? 1 : 0;
  found += trial.found ? 1 : 0;
  wrong += trial.wrong ? 1 : 0;
}

std::string KidnapSummary::text() const {
  char result[200];
  std::snprintf(result, sizeof result,
                "carried %.0f to %.0f m away: noticed within 1 s %zu of %zu, found within %.0f m "
                "%zu, at a wrong place after 1 s %zu",
                kLeastKidnapM, kMostKidnapM, noticed, trials, kKidnapTravelM, found, wrong);
  return result;
}

struct KidnappedFlights::Carriage {
  Place place;  ///< with the plan of the whole flight
  Eigen::Vector2d from, to;
};

KidnappedFlights::KidnappedFlights(Place place) : place_(std::move(place)), vehicle_(vehicleOf()) {
  SimulatedRecording recording(place_, vehicle_, 1);
  OfflineRun run = runOffline(recording, kidnapConfig());
  if (!run.session) throw std::runtime_error(place_.name + ": nothing was mapped");
  map_T_world_ = evaluateReference(run.trajectory, recording.truth()).reference_T_map.inverse();
  session_ = std::make_shared<const Session>(std::move(*run.session));
}

std::optional<KidnappedFlights::Carriage> KidnappedFlights::carriage(std::uint64_t number) const {
  const std::vector<FlightPlan::Waypoint>& all = place_.plan.waypoints;
  if (all.size() < kBeforeWaypoints + kAfterWaypoints) return std::nullopt;
  Random random(number);
  const auto index = [&](std::size_t parts) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(all.size() - parts + 1));
  };
  const std::size_t first = index(kBeforeWaypoints), second = index(kAfterWaypoints);
  const double turn = random.uniform(-3.0, 3.0);
  Carriage result;
  result.place = place_;
  std::vector<FlightPlan::Waypoint>& plan = result.place.plan.waypoints;
  plan.assign(all.begin() + static_cast<std::ptrdiff_t>(first),
              all.begin() + static_cast<std::ptrdiff_t>(first + kBeforeWaypoints));
  plan.back().hover_s = kHoverS;
  for (std::size_t i = second; i < second + kAfterWaypoints; ++i) {
    plan.push_back(all[i]);
    plan.back().yaw += turn;
  }
  plan[kBeforeWaypoints].hover_s = kHoverS;
  result.from = plan[kBeforeWaypoints - 1].position.head<2>();
  result.to = plan[kBeforeWaypoints].position.head<2>();
  const double away = (result.from - result.to).norm();
  if (away < kLeastKidnapM || away > kMostKidnapM) return std::nullopt;
  return result;
}

std::optional<KidnapTrial> KidnappedFlights::fly(std::uint64_t number) const {
  const std::optional<Carriage> carried = carriage(number);
  if (!carried) return std::nullopt;
  const std::unique_ptr<Motion> motion =
      flyQuadrotor(carried->place.plan, carried->place.quadrotor, number);
  BlockedView cover = coverOf(*motion, carried->from, carried->to);
  cover.range_m = number % 2 == 0 ? kCoverRangeM : 0.0;
  VehicleModel vehicle = vehicle_;
  vehicle.blocked_views.push_back(cover);
  SimulatedRecording recording(carried->place, vehicle, number);
  RunOptions options;
  const SlamConfig config = kidnapConfig();
  options.localize_in = std::make_shared<Submap>(submapOf(*session_, config.mapper.grid));
  options.start = givenStart(map_T_world_ * recording.truth().front().pose);
  KidnapTrial trial;
  std::optional<Pose2> last;
  bool done = false;
  options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    const double seconds = scan.stamp - kFlightStart - cover.until_s;
    const Pose2 truth = map_T_world_ * truePose(*motion, scan.stamp);
    const bool lost = result.state == MatchState::kLost;
    if (scan.stamp - kFlightStart > cover.from_s && seconds < 0.0 && lost) trial.noticed = true;
    if (seconds < 0.0 || done) return;
    if (last) trial.travel_m += last->between(truth).distance();
    last = truth;
    done = trial.travel_m > kKidnapTravelM ||
           trial.add(seconds, lost, truth.between(result.pose).distance());
  };
  runOffline(recording, config, options, [&](const OfflineProgress&) { return !done; });
  return trial;
}

}  // namespace kestrel
