// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/walker_measurement.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

constexpr double kVisibleRadius = 0.4;  // m; returns this near to the middle are of the person
// The matched scan has no returns of what moves: such a beam ends this much before the return, m.
constexpr double kFreeBefore = 0.3;
constexpr std::ptrdiff_t kVisibleReturns = 3;  // of a person who can be tracked

/// What a run shows, in the form of the files of track_recording.
class Observer {
 public:
  explicit Observer(const FlightTrial& trial)
      : world_(trial.place.parts),
        truth_(SimulatedRecording(trial.place, trial.vehicle, trial.seed).truth()) {}

  void add(const MappedSweep& sweep) {
    if (sweep.moving == nullptr || !sweep.moving->result().used) return;
    const double stamp = sweep.scan.stamp;
    path_.push_back({stamp, sweep.moving->pose()});
    for (const Track& track : sweep.moving->result().tracks) {
      rows_.push_back({stamp, track.id, track.isShown(), track.position, track.velocity,
                       track.state == TrackState::kTentative, track.moved});
    }
    addPeople(sweep.scan, sweep.moving->result().motion);
  }

  TrackEvaluation evaluate() const {
    return evaluateTracks(path_, rows_, people_, TrackEvaluationOptions());
  }

 private:
  void addPeople(const PlanarScan& scan, const std::vector<CellMotion>& motion) {
    const auto true_pose =
        std::lower_bound(truth_.begin(), truth_.end(), scan.stamp,
                         [](const StampedPose& pose, double stamp) { return pose.stamp < stamp; });
    if (true_pose == truth_.end()) return;
    for (std::size_t i = 0; i < world_.parts().walkers.size(); ++i) {
      const Eigen::Vector2d position =
          true_pose->pose.inverse() * world_.walkerAt(i, scan.stamp - kFlightStart);
      people_.push_back(
          {scan.stamp, static_cast<long>(i), position, isVisible(scan, motion, position)});
    }
  }

  static bool isVisible(const PlanarScan& scan, const std::vector<CellMotion>& motion,
                        const Eigen::Vector2d& position) {
    std::ptrdiff_t returns = 0;
    for (std::size_t i = 0; i < scan.rays.size(); ++i) {
      if (motion[i] != CellMotion::kNone && endsAt(scan.rays[i], position)) ++returns;
    }
    return returns >= kVisibleReturns;
  }

  static bool endsAt(const PlanarRay& ray, const Eigen::Vector2d& position) {
    const Eigen::Vector2d offset = position - ray.origin.cast<double>();
    const Eigen::Vector2d beam = (ray.end - ray.origin).cast<double>(), along = beam.normalized();
    const double across = std::abs(along.x() * offset.y() - along.y() * offset.x());
    const double behind = along.dot(offset) - beam.norm();
    return across < kVisibleRadius && behind > -kVisibleRadius &&
           behind < kVisibleRadius + (ray.hit ? 0.0 : kFreeBefore);
  }

  World world_;
  Trajectory truth_, path_;
  std::vector<TrackRow> rows_;
  std::vector<TrueObject> people_;
};

}  // namespace

WalkerMeasurement measureWalkers(HardFlight flight) {
  WalkerMeasurement result;
  result.without = measureHardFlight(flight);
  Observer observer(flight.trial);
  flight.trial.config.tracker = true;
  flight.trial.options.sweep_observer = [&](const MappedSweep& sweep) { observer.add(sweep); };
  result.with = measureHardFlight(flight);
  result.tracks = observer.evaluate();
  return result;
}

}  // namespace kestrel
