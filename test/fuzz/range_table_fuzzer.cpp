// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/range_table.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(range_table, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    looksLikeRangeTable(file.path());
    RangeTable table(file.path(), RecordingOptions());
    readAll(table);
  });
}

}  // namespace kestrel::fuzz
