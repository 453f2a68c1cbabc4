// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/beam_filter.h"

namespace kestrel {

/// All user parameters, for offline and live operation.
struct SlamConfig {
  /// With a pose graph. MapperConfig alone has none: nobody corrects the poses of its submaps.
  SlamConfig() { mapper.window.enabled = true; }

  ProjectorConfig projector;
  AttitudeConfig attitude;
  MapperConfig mapper;
  LoopConfig loops;
};

}  // namespace kestrel
