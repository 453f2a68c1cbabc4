// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/evaluation/covariance_file.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(covariances, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    for (const ScanCovariance& entry : readCovariances(file.path())) {
      FUZZ_CHECK(entry.pose.map_covariance.allFinite());
      FUZZ_CHECK(entry.pose.match_covariance.allFinite());
    }
  });
}

}  // namespace kestrel::fuzz
