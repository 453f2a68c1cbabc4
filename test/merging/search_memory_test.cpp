// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/search_memory.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

SearchMemory::Key keyOf(double value) {
  KeyMaker key;
  key.add(value);
  return key.key();
}

double ask(SearchMemory& memory, double value) {
  return memory.result(keyOf(value), [&] { return SearchMemory::Numbers{2.0 * value}; })[0];
}

TEST(SearchMemory, SearchesOnce) {
  SearchMemory memory;
  EXPECT_EQ(ask(memory, 1.0), 2.0);
  EXPECT_EQ(ask(memory, 1.0), 2.0);
  EXPECT_EQ(ask(memory, 1.5), 3.0);
  EXPECT_EQ(memory.searches(), 2U);
}

TEST(SearchMemory, ForgetsWhatWasNotUsed) {
  SearchMemory memory;
  ask(memory, 1.0);
  ask(memory, 2.0);
  memory.forgetUnused();
  ask(memory, 2.0);
  memory.forgetUnused();
  EXPECT_EQ(memory.size(), 1U);
}

TEST(SearchMemory, AFileBringsTheResultsBack) {
  SearchMemory memory;
  for (int i = 0; i < 100; ++i) ask(memory, i);
  const std::string bytes = memory.encode("parameters");
  SearchMemory again;
  again.decode(bytes, "parameters");
  EXPECT_EQ(again.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(ask(again, i), 2.0 * i);
  EXPECT_EQ(again.searches(), 0U);
}

TEST(SearchMemory, OtherParametersAndDamagedFilesAreSearchedAgain) {
  SearchMemory memory;
  for (int i = 0; i < 100; ++i) ask(memory, i);
  const std::string bytes = memory.encode("parameters");
  SearchMemory other;
  other.decode(bytes, "others");
  EXPECT_EQ(other.size(), 0U);
  for (std::size_t at = 0; at < bytes.size(); at += 37) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x20);
    SearchMemory read;
    read.decode(damaged, "parameters");
    EXPECT_EQ(read.size(), 0U) << at;
    read.decode(bytes.substr(0, at), "parameters");
    EXPECT_EQ(read.size(), 0U) << at;
  }
}

}  // namespace
}  // namespace kestrel
