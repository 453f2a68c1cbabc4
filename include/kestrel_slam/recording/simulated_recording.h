// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// Where the base truly is at `stamp` (s, as in the messages of a simulated flight), seen from
/// above.
Pose2 truePose(const Motion& motion, double stamp);

/// A simulated flight as a recording, without a file: scans are simulated when they are read. With
/// a 2D laser on board it holds the scans of that, else the clouds of the lidar.
class SimulatedRecording : public Recording {
 public:
  /// Flies the place's own plan. Throws std::invalid_argument where nothing on board scans.
  SimulatedRecording(const Place& place, const VehicleModel& vehicle, std::uint64_t seed);
  ~SimulatedRecording() override;

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override;  ///< without the lost ones
  std::string description() const override;
  bool hasOdometry() const override { return false; }

  /// world_T_base at the stamp of every scan, also of those not read yet.
  const Trajectory& truth() const;
  /// The same in space: `trueStates()[i]` belongs to `truth()[i]`.
  const std::vector<TrueState>& trueStates() const;

  const World& world() const;
  const Motion& motion() const;

 private:
  struct State;
  void recordEarly(const FlightEvent& event);
  bool readScan(const FlightEvent& event, RecordedScan& scan);

  std::unique_ptr<State> state_;
};

}  // namespace kestrel
