// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/cloud_file.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(cloud_file, bytes) {
  for (const char* ending : {"", ".bin", ".pcd.bin"}) {
    const FuzzFile file(bytes, ending);
    expectResultOrReason([&] { readCloudFile(file.path()); });
  }
}

}  // namespace kestrel::fuzz
