// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "kestrel_slam/offline/odometry_error.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// Which data a run removes from its recording or falsifies. A robust result must not depend on
/// small changes of the data.
struct Perturbation {
  std::size_t skip_scans = 0;     ///< number of scans to remove at the start
  std::size_t drop_every = 0;     ///< 7: the 7th, 14th, ... scan of the recording; 0: none
  double drop_beams_share = 0.0;  ///< share of beams to remove from each scan, 0 to 1
  std::uint64_t beams_seed = 1;   ///< seed for the choice of beams
  OdometryError odometry;         ///< added to the odometry (see OdometryDistortion)
};

/// Removes beams from `scan`, which has the given `number` in its recording (counted from 1). Their
/// readings become NaN, as if the sensor received no echo. Returns false if the whole scan is
/// removed. The result for a scan does not depend on other scans.
bool perturb(const Perturbation& perturbation, std::size_t number, RecordedScan& scan);

}  // namespace kestrel
