// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "file_bytes.h"
#include "kestrel_slam/session/chunk_file.h"

namespace kestrel::chunk_format {

/// Not a text, and changed by every transfer that takes it for one.
constexpr char kMagic[] = "\x89KSLAM\r\n";
constexpr std::uint64_t kMagicBytes = 8;
constexpr std::uint32_t kContainerVersion = 1;
constexpr std::uint64_t kMaxWriterBytes = 255;
constexpr std::uint64_t kFixedHeaderBytes = kMagicBytes + 4 + 4;
constexpr std::uint64_t kTagBytes = 4;
constexpr std::uint64_t kCheckedHeadBytes = kTagBytes + 4 + 8 + 8;
constexpr std::uint64_t kChecksumBytes = 8;
constexpr std::uint64_t kHeadBytes = kCheckedHeadBytes + kChecksumBytes;
/// zlib makes content that it cannot pack longer by less than a thousandth.
constexpr std::uint64_t kMaxPackedBytes =
    ChunkWriter::kMaxContentBytes + ChunkWriter::kMaxContentBytes / 1000;
constexpr char kTableTag[] = "TOC ";

inline std::string tableOf(const std::vector<Chunk>& chunks) {
  std::string table;
  for (const Chunk& chunk : chunks) {
    table += chunk.tag;
    appendNumber(table, chunk.schema_version, 4);
    appendNumber(table, chunk.offset, 8);
    appendNumber(table, chunk.packed_bytes, 8);
  }
  return table;
}

}  // namespace kestrel::chunk_format
