// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/walker_measurement.h"

#include <algorithm>
#include <vector>

#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

constexpr double kVisibleRadius = 0.4;  // m; returns this near to the middle are of the person
constexpr std::ptrdiff_t kVisibleReturns = 3;  // of a person who can be tracked

/// What a run shows, in the form of the files of track_recording.
class Observer {
 public:
  explicit Observer(const FlightTrial& trial)
      : walkers_(trial.place.parts.walkers),
        truth_(SimulatedRecording(trial.place, trial.vehicle, trial.seed).truth()) {}

  void add(const MappedSweep& sweep) {
    if (sweep.moving == nullptr || !sweep.moving->result().used) return;
    const double stamp = sweep.scan.stamp;
    path_.push_back({stamp, sweep.moving->pose()});
    for (const Track& track : sweep.moving->result().tracks) {
      rows_.push_back({stamp, track.id, track.isShown(), track.position, track.velocity});
    }
    addPeople(sweep.scan);
  }

  TrackEvaluation evaluate() const {
    return evaluateTracks(path_, rows_, people_, TrackEvaluationOptions());
  }

 private:
  void addPeople(const PlanarScan& scan) {
    const auto true_pose =
        std::lower_bound(truth_.begin(), truth_.end(), scan.stamp,
                         [](const StampedPose& pose, double stamp) { return pose.stamp < stamp; });
    if (true_pose == truth_.end()) return;
    for (std::size_t i = 0; i < walkers_.size(); ++i) {
      const Eigen::Vector2d position =
          true_pose->pose.inverse() * walkers_[i].at(scan.stamp - kFlightStart);
      if (isVisible(scan, position)) {
        people_.push_back({scan.stamp, static_cast<long>(i), position});
      }
    }
  }

  static bool isVisible(const PlanarScan& scan, const Eigen::Vector2d& position) {
    return std::count_if(scan.rays.begin(), scan.rays.end(), [&](const PlanarRay& ray) {
             return ray.hit && (ray.end.cast<double>() - position).norm() < kVisibleRadius;
           }) >= kVisibleReturns;
  }

  std::vector<Walker> walkers_;
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
