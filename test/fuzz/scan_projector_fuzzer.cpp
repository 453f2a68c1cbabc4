// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_scans.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel::fuzz {
namespace {

void step(FuzzInput& input, double stamp, ScanProjector& projector, AttitudeBuffer& attitude) {
  for (int n = input.below(8); n > 0; --n) {
    std::optional<Eigen::Vector3d> rate, force;
    if (input.flag()) rate = input.anyVector(2.0);
    if (input.flag()) force = input.anyVector(12.0);
    attitude.add(stamp + 0.02 * n, input.anyRotation(), rate, force);
  }
  VehicleState vehicle;
  if (input.flag()) vehicle.attitude = &attitude;
  // ProjectionStage lets only plausible heights and velocities through.
  if (input.flag()) vehicle.height_m = input.within(-1.0, 4.0);
  if (input.flag()) vehicle.velocity = {input.within(-50, 50), input.within(-50, 50)};
  const Eigen::Isometry3d mounting = input.anyMounting();
  const Projection projection =
      input.flag() ? projector.project(anyLaserScan(input, stamp), mounting, vehicle)
                   : projector.project(anyCloud(input, stamp), mounting, vehicle);
  if (projection.error == ScanError::kNone) {
    checkScan(projection.scan);
  } else {
    FUZZ_CHECK(!projection.message.empty());
  }
}

}  // namespace

KESTREL_FUZZER(scan_projector, bytes) {
  FuzzInput input(bytes);
  ScanProjector projector{ProjectorConfig()};
  AttitudeBuffer attitude;
  FuzzClock clock;
  while (!input.atEnd()) step(input, clock.next(input), projector, attitude);
}

}  // namespace kestrel::fuzz
