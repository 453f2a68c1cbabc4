// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/chunk_file.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "../../src/session/file_bytes.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// A file with three chunks: a text, nothing, and bytes that cannot be packed.
std::string sampleFile() {
  std::mt19937 random(2);
  std::string noise(300, '\0');
  for (char& c : noise) c = static_cast<char>(random());
  ChunkWriter writer("test 1.0");
  writer.add("TEXT", 3, std::string(500, 'a') + "b");
  writer.add("NONE", 1, "");
  writer.add("NOIS", 0xFFFFFFFFU, noise);
  return writer.finish();
}

std::string reasonOf(const std::string& bytes) {
  return messageOf([&] { ChunkReader reader(bytes); });
}

/// The first damage, or why nothing can be read, or "".
std::string damageOf(const std::string& bytes) {
  try {
    const ChunkReader reader(bytes);
    for (const Chunk& chunk : reader.chunks()) reader.content(chunk);
    return reader.damage().empty() ? "" : reader.damage().front();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

TEST(ChunkFile, GivesBackWhatWasWritten) {
  const std::string bytes = sampleFile();
  const ChunkReader reader(bytes);
  EXPECT_EQ(reader.writer(), "test 1.0");
  EXPECT_EQ(reader.containerVersion(), 1U);
  EXPECT_TRUE(reader.damage().empty());
  ASSERT_EQ(reader.chunks().size(), 3U);
  EXPECT_EQ(reader.chunks()[0].tag, "TEXT");
  EXPECT_EQ(reader.chunks()[0].schema_version, 3U);
  EXPECT_EQ(reader.content(reader.chunks()[0]), std::string(500, 'a') + "b");
  EXPECT_LT(reader.chunks()[0].packed_bytes, 50U);
  EXPECT_EQ(reader.content(reader.chunks()[1]), "");
  EXPECT_EQ(reader.content(reader.chunks()[2]).size(), 300U);
  EXPECT_EQ(sampleFile(), bytes);
}

TEST(ChunkFile, FindsEveryFlippedBit) {
  const std::string bytes = sampleFile();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      ASSERT_NE(damageOf(damaged), "") << "byte " << i << ", bit " << bit;
    }
  }
}

TEST(ChunkFile, FindsEveryTruncationAndEveryAddition) {
  const std::string bytes = sampleFile();
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ASSERT_NE(damageOf(bytes.substr(0, length)), "") << length;
  }
  EXPECT_NE(damageOf(bytes + '\0'), "");
  EXPECT_NE(damageOf(bytes + bytes), "");
}

TEST(ChunkFile, NamesChunkAndPlaceOfTheDamage) {
  const std::string bytes = sampleFile();
  const ChunkReader whole(bytes);
  const std::uint64_t second = whole.chunks()[1].offset, third = whole.chunks()[2].offset;
  const auto flipped = [&](std::uint64_t at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    return damageOf(damaged);
  };
  EXPECT_EQ(flipped(second + 32),
            "chunk 1 (NONE) at byte " + std::to_string(second) + " has a wrong checksum");
  EXPECT_EQ(flipped(third + 15), "chunk 2 (NOIS) at byte " + std::to_string(third) +
                                     " is longer than the file, or cut off");
  EXPECT_EQ(
      damageOf(bytes.substr(0, third + 40)),
      "chunk 2 (NOIS) at byte " + std::to_string(third) + " is longer than the file, or cut off");
  EXPECT_EQ(damageOf(bytes.substr(0, third)),
            "the file ends at byte " + std::to_string(third) + " before chunk 2 is complete");
  EXPECT_CONTAINS(flipped(bytes.size() - 1), "the checksum of the whole file at byte ");
  EXPECT_EQ(flipped(17), "its header at byte 0 is damaged");
}

TEST(ChunkFile, KeepsTheWholeChunksOfADamagedFile) {
  std::string bytes = sampleFile();
  const std::uint64_t first = ChunkReader(bytes).chunks()[0].offset;
  bytes[first + 40] = static_cast<char>(bytes[first + 40] ^ 4);
  const ChunkReader reader(bytes);
  EXPECT_EQ(reader.damage().size(), 1U);
  ASSERT_EQ(reader.chunks().size(), 2U);
  EXPECT_EQ(reader.chunks()[0].tag, "NONE");
}

TEST(ChunkFile, FindsTheChunksBehindADamagedHeader) {
  const std::string bytes = sampleFile();
  const std::uint64_t first = ChunkReader(bytes).chunks()[0].offset;
  for (std::uint64_t i = 8; i < first; ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x11);
    const ChunkReader reader(damaged);
    EXPECT_EQ(reader.chunks().size(), 3U) << i;
    EXPECT_EQ(reader.damage().front(), "its header at byte 0 is damaged");
  }
}

TEST(ChunkFile, SaysWhatIsNoSessionAndWhatIsNewer) {
  EXPECT_EQ(reasonOf(""), "it is not a session of kestrel_slam");
  EXPECT_EQ(reasonOf("P5\n10 10\n255\n"), "it is not a session of kestrel_slam");
  std::string header = ChunkWriter("k 9.9").finish().substr(0, 21);
  header[8] = 7;  // the container version
  std::string newer = header;
  appendNumber(newer, checksumOf(header, 0, header.size()), 8);
  EXPECT_EQ(reasonOf(newer), "it has the newer format 7; read it with k 9.9");
  EXPECT_EQ(reasonOf(header), "its header at byte 0 is damaged; nothing of it can be read");
}

TEST(ChunkFile, RefusesTagsAndContentsThatItCannotHold) {
  ChunkWriter writer("test");
  EXPECT_THROW(writer.add("TOC ", 1, ""), std::invalid_argument);
  EXPECT_THROW(writer.add("LONGER", 1, ""), std::invalid_argument);
  const std::string large(ChunkWriter::kMaxContentBytes + 1, 'x');
  EXPECT_THROW(writer.add("MUCH", 1, large), std::invalid_argument);
  writer.add("MUCH", 1, large.substr(1));
  const std::string bytes = writer.finish();
  const ChunkReader reader(bytes);
  EXPECT_TRUE(reader.damage().empty());
  EXPECT_TRUE(reader.content(reader.chunks()[0]) == large.substr(1));
}

}  // namespace
}  // namespace kestrel
