// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/mapping_stage.h"

namespace kestrel {

MapperResult MappingStage::process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                                   const std::optional<double>& time) {
  scan.time = time ? *time : monotone_time_.repair(scan.stamp);
  return mapper_.process(scan, odom_T_base);
}

void MappingStage::restartMotion() {
  const Pose2 pose = mapper_.pose();  // copy: setPose changes the value behind pose()
  mapper_.setPose(pose);
}

}  // namespace kestrel
