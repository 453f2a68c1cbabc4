// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/evaluation/evaluation.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(relations, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    for (const Relation& relation : readRelations(file.path()))
      FUZZ_CHECK(relation.pose.isFinite());
  });
}

}  // namespace kestrel::fuzz
