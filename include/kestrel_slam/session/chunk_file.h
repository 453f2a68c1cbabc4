// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kestrel {

// A file of chunks. Numbers are unsigned and little-endian; a checksum is the XXH64 of what it
// covers.
//
//   header           magic (8 bytes), container version (4), length of the writer's name (4),
//                    writer's name, checksum of the header so far (8)
//   chunk, repeated  tag (4 letters), schema version (4), length (8), length after unpacking (8),
//                    checksum of these 24 bytes and the content (8), content packed by zlib
//   chunk "TOC "     table of contents: for each chunk its tag, schema version, place in the file
//                    and length
//   checksum of everything before (8)
//
// A file that was cut off has no end, and no byte can change unnoticed.

/// Where a chunk is in the file.
struct Chunk {
  std::string tag;  ///< four letters
  std::uint32_t schema_version = 0;
  std::uint64_t offset = 0;         ///< of its first byte in the file
  std::uint64_t packed_bytes = 0;   ///< without its head
  std::uint64_t content_bytes = 0;  ///< after unpacking

  /// "chunk 3 (KEYF) at byte 1234"
  std::string describe(std::size_t number) const;
};

/// Makes the bytes of a file. The same chunks give the same bytes.
class ChunkWriter {
 public:
  /// More content must be divided into several chunks.
  static constexpr std::uint64_t kMaxContentBytes = 1U << 26U;

  /// `writer`: name and version of the program, up to 255 bytes.
  explicit ChunkWriter(const std::string& writer);

  /// Throws std::invalid_argument if the tag has not four letters or the content is too long.
  void add(const std::string& tag, std::uint32_t schema_version, const std::string& content);
  /// The whole file. Call it once, after the last chunk.
  std::string finish();

 private:
  void append(const std::string& tag, std::uint32_t schema_version, const std::string& content);

  std::string bytes_;
  std::vector<Chunk> chunks_;
};

/// Looks through the bytes of a file. Lengths are believed only as far as the file reaches.
class ChunkReader {
 public:
  /// `bytes` must outlive the reader. Throws std::runtime_error if this is not a file of chunks, if
  /// a newer version has written it, or if nothing of it can be read.
  explicit ChunkReader(const std::string& bytes);

  const std::string& writer() const { return writer_; }
  std::uint32_t containerVersion() const { return container_version_; }
  /// All whole chunks but the table of contents, in the order of the file. Chunks that follow a
  /// damaged one are found if its length is right.
  const std::vector<Chunk>& chunks() const { return chunks_; }
  /// What is wrong, with chunk and place; empty if the file is whole.
  const std::vector<std::string>& damage() const { return damage_; }

  /// Throws std::runtime_error if the content cannot be unpacked.
  std::string content(const Chunk& chunk) const;

 private:
  bool readHeader();
  void findFirstChunk();
  void readChunks();
  bool readChunk(std::uint64_t& offset);
  Chunk chunkAt(std::uint64_t offset) const;
  bool fits(const Chunk& chunk) const;
  bool isWhole(const Chunk& chunk) const;
  bool contains(const Chunk& chunk, const std::string& expected) const;
  void readEnd(const Chunk& table, std::uint64_t offset);

  const std::string& bytes_;
  std::string writer_;
  std::uint32_t container_version_ = 0;
  std::vector<Chunk> chunks_;
  std::vector<std::string> damage_;
  std::uint64_t first_chunk_ = 0;
  std::size_t seen_ = 0;  ///< chunks, with damaged ones
};

}  // namespace kestrel
