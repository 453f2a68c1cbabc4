// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/perturbation.h"

#include <limits>

#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

/// Multiplier that gives each scan a different seed (2^64 divided by the golden ratio).
constexpr std::uint64_t kSeedStep = 0x9e3779b97f4a7c15ULL;

}  // namespace

bool perturb(const Perturbation& perturbation, std::size_t number, RecordedScan& scan) {
  if (number <= perturbation.skip_scans) return false;
  if (perturbation.drop_every > 0 && number % perturbation.drop_every == 0) return false;
  if (perturbation.drop_beams_share <= 0.0) return true;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Random random(perturbation.beams_seed + kSeedStep * number);
  for (float& range : scan.scan.ranges) {
    if (random.uniform() < perturbation.drop_beams_share) range = kNan;
  }
  if (!scan.cloud) return true;
  for (PointCloud::Point& point : scan.cloud->points) {
    if (random.uniform() < perturbation.drop_beams_share) point.x = point.y = point.z = kNan;
  }
  return true;
}

}  // namespace kestrel
