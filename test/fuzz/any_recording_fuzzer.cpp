// SPDX-License-Identifier: BSD-3-Clause

#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(any_recording, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    const auto recording = openRecording(file.path(), RecordingOptions());
    readAll(*recording);
  });
}

}  // namespace kestrel::fuzz
