// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// What a run leaves out of its recording: a result that depends on it was luck.
struct Perturbation {
  std::size_t skip_scans = 0;     ///< so many at the start
  std::size_t drop_every = 0;     ///< 7: the 7th, 14th, ... scan of the recording; 0: none
  double drop_beams_share = 0.0;  ///< of the beams (points of a cloud) of each scan, 0 to 1
  std::uint64_t beams_seed = 1;   ///< which of them
};

/// Drops beams of `scan`, the `number`-th of its recording (from 1), as a sensor does that gets no
/// echo: their readings become NaN. False where the whole scan is left out. What happens to a scan
/// does not depend on the others.
bool perturb(const Perturbation& perturbation, std::size_t number, RecordedScan& scan);

}  // namespace kestrel
