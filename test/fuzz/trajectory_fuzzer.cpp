// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(trajectory, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    for (const StampedPose& entry : readTum(file.path())) FUZZ_CHECK(entry.pose.isFinite());
  });
}

}  // namespace kestrel::fuzz
