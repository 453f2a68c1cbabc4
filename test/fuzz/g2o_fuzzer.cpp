// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "fuzz/fuzzer.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/graph/optimizer.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(g2o, bytes) {
  try {
    G2oGraph file = parseG2o(bytes, "fuzz.g2o");
    FUZZ_CHECK(g2oText(parseG2o(g2oText(file), "again.g2o")) == g2oText(file));
    optimize(file.graph);
    FUZZ_CHECK(problemOf(file.graph).empty());
  } catch (const std::runtime_error& error) {
    FUZZ_CHECK(!std::string(error.what()).empty());
  }
}

}  // namespace kestrel::fuzz
