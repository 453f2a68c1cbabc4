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

/// True pose of the base in the plane at `stamp` (s, as in the messages of a simulated flight).
Pose2 truePose(const Motion& motion, double stamp);

/// A simulated flight as a recording, without a file. Scans are simulated when they are read. If
/// the vehicle has a 2D laser, the recording consists of its scans, else of the clouds of the
/// lidar.
class SimulatedRecording : public Recording {
 public:
  /// Simulates the standard flight of `place`. Throws std::invalid_argument if the vehicle has
  /// neither a laser nor a lidar.
  SimulatedRecording(const Place& place, const VehicleModel& vehicle, std::uint64_t seed);
  ~SimulatedRecording() override;

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override;  ///< without lost scans
  std::string description() const override;
  bool hasOdometry() const override { return false; }

  /// world_T_base at the stamp of every scan, including scans that are not read yet.
  const Trajectory& truth() const;
  /// The same with all three dimensions: `trueStates()[i]` belongs to `truth()[i]`.
  const std::vector<TrueState>& trueStates() const;

  const World& world() const;
  const Motion& motion() const;

 private:
  struct State;
  void recordFirstPass(const FlightEvent& event);
  bool readScan(const FlightEvent& event, RecordedScan& scan);

  std::unique_ptr<State> state_;
};

}  // namespace kestrel
