// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/hard_flight.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

constexpr double kFalseAlarm = 0.2;  // m
constexpr double kMissed = 0.5;      // m
/// Largest distance of a ghost cell from a former position of a person, an object or the vehicle,
/// m. Covers half the width of a person and the distance of a blocked view.
constexpr double kGhostReach = 0.6;

/// The poses of the scans that are not lost.
Trajectory trackedPoses(const OfflineRun& run) {
  Trajectory result;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    if (run.scans[i].state != MatchState::kLost) result.push_back(run.trajectory[i]);
  }
  return result;
}

/// Classifies occupied cells of the final map with the objects at the end of the flight.
class CellClassifier {
 public:
  CellClassifier(const World::Parts& parts, const Trajectory& flown, double end_s)
      : walkers_(parts.walkers), flown_(flown) {
    for (std::size_t i = 0; i < walkers_.size(); ++i) {
      reach_.push_back(kGhostReach + mostAside(walkers_, i));
    }
    at_end_.cylinders = parts.cylinders;
    for (const Box& box : parts.boxes) {
      (box.from_s <= end_s && end_s < box.until_s ? at_end_ : gone_).boxes.push_back(box);
    }
  }

  bool isFalse(const Eigen::Vector2d& point) const {
    return distanceToUprightSurface(at_end_, point) > kFalseDistance;
  }

  bool isGhost(const Eigen::Vector2d& point) const {
    if (distanceToUprightSurface(gone_, point) < kGhostReach) return true;
    for (std::size_t i = 0; i < walkers_.size(); ++i) {
      if (walkers_[i].distanceToPath(point) < reach_[i]) return true;
    }
    return std::any_of(flown_.begin(), flown_.end(), [&](const auto& flown) {
      return (flown.pose.translation() - point).norm() < kGhostReach;
    });
  }

 private:
  World::Parts at_end_, gone_;
  std::vector<Walker> walkers_;
  std::vector<double> reach_;  ///< of each walker: ghost cells are nearer to its path, m
  const Trajectory& flown_;
};

void countCells(const CellClassifier& classifier, const MapSnapshot& map, const Pose2& world_T_map,
                HardFlightMeasurement& result) {
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      const Eigen::Vector2d in_map(map.origin_x + (column + 0.5) * map.resolution_m,
                                   map.origin_y + (row + 0.5) * map.resolution_m);
      const Eigen::Vector2d point = world_T_map * in_map;
      if (!classifier.isFalse(point)) continue;
      ++(classifier.isGhost(point) ? result.ghost_cells : result.double_cells);
    }
  }
}

/// Compares the scans with the truth; `reference` has the true poses at their stamps.
void evaluateScans(const HardFlight& hard, const Pose2& world_T_map, const Trajectory& reference,
                   HardFlightMeasurement& result) {
  const OfflineRun& run = result.flight.run;
  bool was_lost = true;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const double time = run.trajectory[i].stamp - kFlightStart;
    const bool lost = run.scans[i].state == MatchState::kLost;
    const bool blind = time >= hard.blind_from_s && time < hard.blind_until_s;
    const Pose2 pose = world_T_map * run.trajectory[i].pose;
    const double error = (reference[i].pose.translation() - pose.translation()).norm();
    result.lost += lost ? 1U : 0U;
    if (lost && !blind && error < kFalseAlarm) ++result.false_alarms;
    if (!lost && error > kMissed) ++result.missed;
    if (!lost && !blind && time >= hard.blind_until_s && hard.blind_until_s > 0.0 &&
        result.recovery_s == 0.0) {
      result.recovery_s = time - hard.blind_until_s;
    }
    if (!lost && !was_lost) {
      const Pose2 estimated = run.trajectory[i - 1].pose.inverse() * run.trajectory[i].pose;
      const Pose2 truth = reference[i - 1].pose.inverse() * reference[i].pose;
      result.jump_m =
          std::max(result.jump_m, (estimated.translation() - truth.translation()).norm());
    }
    was_lost = lost;
  }
}

}  // namespace

HardFlightMeasurement measureHardFlight(const HardFlight& hard) {
  HardFlightMeasurement result;
  result.flight = measureFlight(hard.trial);
  const FlightMeasurement& flight = result.flight;
  // Lost poses are excluded from the alignment.
  const ReferenceEvaluation error =
      evaluateReference(trackedPoses(flight.run), flight.error.reference);
  result.ate_m = error.ate_statistics.translation_m.rmse;
  evaluateScans(hard, error.reference_T_map, flight.error.reference, result);
  const double end = flight.error.reference.back().stamp - kFlightStart;
  const CellClassifier classifier(hard.trial.place.parts, flight.error.reference, end);
  countCells(classifier, flight.run.map, error.reference_T_map, result);
  return result;
}

std::string HardFlightMeasurement::failures(const HardLimits& limits) const {
  std::ostringstream text;
  const auto check = [&text](const char* name, auto value, auto limit) {
    if (value > limit) text << (text.tellp() > 0 ? ", " : "") << name << " over " << limit;
  };
  check("ATE", ate_m, limits.ate_m);
  check("jump", jump_m, limits.jump_m);
  check("false alarms", false_alarms, limits.false_alarms);
  check("missed", missed, limits.missed);
  check("ghost cells", ghost_cells, limits.ghost_cells);
  check("double walls", double_cells, limits.double_cells);
  check("recovery", recovery_s, limits.recovery_s);
  return text.str();
}

}  // namespace kestrel
