// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/breezy_log.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(breezy_log, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    looksLikeBreezyLog(file.path());
    BreezyLog log(file.path());
    readAll(log);
  });
}

}  // namespace kestrel::fuzz
