// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_scans.h"
#include "kestrel_slam/mapping/mapper.h"

namespace kestrel::fuzz {
namespace {

MapperConfig configOf(FuzzInput& input) {
  const std::vector<std::string> names = matcherNames();
  MapperConfig config;
  config.matcher.method =
      names[static_cast<std::size_t>(input.below(static_cast<int>(names.size())))];
  config.grid.memory_limit_mb = 16.0;
  return config;
}

void step(FuzzInput& input, double time, Mapper& mapper) {
  const int kind = input.below(16);
  if (kind == 1) mapper.reset(anyPose(input));
  if (kind == 2) mapper.setPose(anyPose(input));
  std::optional<Pose2> odometry;
  if (input.flag()) odometry = anyPose(input);
  checkResult(mapper.process(anyPlanarScan(input, time), odometry));
}

}  // namespace

KESTREL_FUZZER(mapper, bytes) {
  FuzzInput input(bytes);
  Mapper mapper(configOf(input));
  FuzzClock clock;
  while (!input.atEnd()) step(input, clock.next(input), mapper);
  const MapSnapshot map = mapper.snapshot();
  FUZZ_CHECK(map.cells.size() ==
             static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
}

}  // namespace kestrel::fuzz
