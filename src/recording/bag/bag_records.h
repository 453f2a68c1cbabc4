// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace kestrel {

enum BagOp : unsigned char {
  kMessageData = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

/// A file that is read in blocks. Nearly all reads of a bag's records are short and follow each
/// other: std::ifstream would read its buffer anew after every seek.
class BlockReader {
 public:
  explicit BlockReader(const std::string& path) : file_(path, std::ios::binary) {}

  /// False if the file ends before.
  bool read(std::uint64_t position, std::uint64_t count, char* bytes);

 private:
  std::ifstream file_;
  std::vector<char> block_;
  std::uint64_t begin_ = 0;  ///< of the block in the file
};

/// A record of a bag: a header and data, each preceded by its length.
struct BagRecord {
  std::uint64_t start = 0;
  std::map<std::string, std::string> fields;
  std::uint64_t data_begin = 0;
  std::uint64_t end = 0;

  bool is(BagOp op) const {
    const auto field = fields.find("op");
    return field != fields.end() && field->second == std::string(1, static_cast<char>(op));
  }
};

/// Reads the records of a bag. Throws BagDamage where a length or a position is impossible.
class BagRecords {
 public:
  explicit BagRecords(const std::string& path);

 protected:
  bool isBag();
  BagRecord readHeader();  ///< the first record
  BagRecord readRecord(std::uint64_t start, std::uint64_t limit);
  std::string readBytes(std::uint64_t position, std::uint64_t count);
  /// The fields in `bytes`, which are at `begin` in the file.
  std::map<std::string, std::string> fieldsOf(const std::string& bytes, std::uint64_t begin) const;
  std::uint64_t number(const BagRecord& record, const std::string& name, std::size_t bytes) const;
  std::uint64_t size() const { return size_; }
  [[noreturn]] void fail(std::uint64_t position) const;

  bool any_chunk_ = false;  ///< a chunk was complete

 private:
  std::uint64_t readLength(std::uint64_t position, std::uint64_t limit);

  BlockReader file_;
  std::uint64_t size_;
};

}  // namespace kestrel
