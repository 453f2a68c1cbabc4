// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/reference.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(reference, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] { readReference(file.path(), "pose"); });
}

}  // namespace kestrel::fuzz
