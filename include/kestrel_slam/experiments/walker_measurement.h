// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/evaluation/track_evaluation.h"
#include "kestrel_slam/experiments/hard_flight.h"

namespace kestrel {

/// A simulated flight among people who walk, with the tracker and without.
struct WalkerMeasurement {
  HardFlightMeasurement without, with;
  /// Tracks compared with the people of whom the laser sees something. Tracks of hidden people are
  /// neither right nor wrong.
  TrackEvaluation tracks;
};

/// Simulates and maps the flight twice. Deterministic.
WalkerMeasurement measureWalkers(HardFlight flight);

}  // namespace kestrel
