// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <utility>

#include "kestrel_slam/pipeline/pipeline.h"

namespace kestrel {

/// Measures the parts of the work of a pipeline between two scans, ms.
class StageClock {
 public:
  /// The work goes on after something else was done.
  void resume() { start_ = Clock::now(); }

  /// Adds the time since the last call to the stage that was running.
  void begin(PipelineStage stage) {
    const Clock::time_point now = Clock::now();
    const std::chrono::duration<double, std::milli> ms = now - start_;
    ms_[static_cast<std::size_t>(stage_)] += ms.count();
    stage_ = stage;
    start_ = now;
  }

  std::array<double, kPipelineStages> take() { return std::exchange(ms_, {}); }

 private:
  using Clock = std::chrono::steady_clock;

  PipelineStage stage_ = PipelineStage::kFilter;
  Clock::time_point start_;
  std::array<double, kPipelineStages> ms_{};
};

}  // namespace kestrel
