// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/bag/bag_recording.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(bag_recording, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    BagRecording bag({file.path()}, RecordingOptions());
    readAll(bag);
  });
}

}  // namespace kestrel::fuzz
