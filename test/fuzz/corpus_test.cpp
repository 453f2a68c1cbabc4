// SPDX-License-Identifier: BSD-3-Clause
// Runs every fuzzer on the files of corpus/<fuzzer>: inputs that once failed, and typical ones.

#include <gtest/gtest.h>

#include <filesystem>

#include "fuzz/fuzzer.h"
#include "kestrel_slam/map/atomic_file.h"

namespace kestrel::fuzz {
namespace {

namespace fs = std::filesystem;

class FuzzCorpus : public ::testing::TestWithParam<Fuzzer> {};

TEST_P(FuzzCorpus, EveryFileGivesAResultOrAReason) {
  const fs::path folder = fs::path(KESTREL_SOURCE_DIR "/test/fuzz/corpus") / GetParam().name;
  GetParam().run("");
  ASSERT_TRUE(fs::is_directory(folder)) << folder << " is missing: every fuzzer has a corpus";
  for (const auto& file : fs::directory_iterator(folder)) {
    SCOPED_TRACE(file.path().string());
    GetParam().run(readFile(file.path().string()));
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzzers, FuzzCorpus, ::testing::ValuesIn(fuzzers()),
                         [](const auto& entry) { return entry.param.name; });

}  // namespace
}  // namespace kestrel::fuzz
