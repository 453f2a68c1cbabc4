// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/carmen_log.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(carmen_log, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    looksLikeCarmenLog(file.path());
    CarmenLog log(file.path());
    readAll(log);
  });
}

}  // namespace kestrel::fuzz
