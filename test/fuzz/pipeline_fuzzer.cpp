// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_scans.h"
#include "kestrel_slam/pipeline/pipeline.h"

namespace kestrel::fuzz {
namespace {

PipelineConfig pipelineConfigOf(FuzzInput& input) {
  PipelineConfig config;
  config.slam.mapper.grid.memory_limit_mb = 16.0;
  config.use_filter = input.flag();
  config.level = input.flag();
  config.level_without_imu = input.flag();
  return config;
}

void checkState(const FilterOutput& state) {
  FUZZ_CHECK(state.map_T_base.matrix().allFinite() && state.odom_T_base.matrix().allFinite());
  FUZZ_CHECK(state.velocity.allFinite() && state.covariance.allFinite());
}

void addScan(FuzzInput& input, double stamp, double arrival, Pipeline& pipeline) {
  PipelineScan scan;
  if (input.below(4) == 1) {
    scan.data = anyCloud(input, stamp);
  } else {
    scan.data = anyLaserScan(input, stamp);
  }
  scan.base_T_laser = input.anyMounting();
  if (input.flag()) scan.odom_T_base = anyPose(input);
  pipeline.addScan(scan, arrival);
}

void step(FuzzInput& input, double stamp, double arrival, Pipeline& pipeline) {
  switch (input.below(8)) {
    case 0:
      return pipeline.addRange({stamp, input.any(0.0, 5.0)}, arrival, input.flag());
    case 1:
      return pipeline.addBarometer({stamp, input.any(0.0, 5.0)}, arrival);
    case 2:
      if (input.below(8) == 1) pipeline.reset(anyPose(input));
      if (input.below(8) == 1) pipeline.setPose(anyPose(input), Eigen::Matrix3d::Identity());
      return;
    case 3:
    case 4:
      return addScan(input, stamp, arrival, pipeline);
    default:
      return pipeline.addImu(anyImu(input, stamp), input.anyMounting(), arrival);
  }
}

}  // namespace

KESTREL_FUZZER(pipeline, bytes) {
  FuzzInput input(bytes);
  Pipeline pipeline(pipelineConfigOf(input));
  pipeline.on_scan = [](const MappedSweep& sweep) { checkResult(sweep.result); };
  pipeline.on_drop = [](const DroppedSweep& sweep) { FUZZ_CHECK(!sweep.reason.empty()); };
  pipeline.on_filter = checkState;
  FuzzClock clock;
  double arrival = 0.0;
  while (!input.atEnd()) {
    const double stamp = clock.next(input);
    arrival = std::isfinite(stamp) ? std::max(arrival, stamp) : arrival;
    step(input, stamp, arrival, pipeline);
  }
  pipeline.finish();
}

}  // namespace kestrel::fuzz
