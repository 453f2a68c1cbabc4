// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>

#include "kestrel_slam/link/number_set.h"

namespace kestrel {

/// A stream of numbered chunks: what one vehicle has mapped since it was started.
struct StreamId {
  std::string vehicle;
  std::uint64_t epoch = 0;  ///< another one for every map that the vehicle begins
};
inline bool operator<(const StreamId& a, const StreamId& b) {
  return a.vehicle != b.vehicle ? a.vehicle < b.vehicle : a.epoch < b.epoch;
}
inline bool operator==(const StreamId& a, const StreamId& b) {
  return a.vehicle == b.vehicle && a.epoch == b.epoch;
}

struct LinkChunk {
  std::uint64_t number = 0;  ///< 1, 2, 3, ...
  /// A later chunk with the same key replaces this one; 0: it is never replaced.
  std::uint32_t key = 0;
  std::string content;
};

/// The chunks of a stream that are here, in a file. Only their places in the file are in memory.
/// After the process was killed, everything is there but the chunk that was being written.
class ChunkJournal {
 public:
  static constexpr std::size_t kMaxContentBytes = 1U << 20U;

  /// Opens or begins the file; with an empty path it is one without a name in the folder for
  /// temporary files, which ends with the process. A damaged end is cut off. Throws
  /// std::runtime_error if the file cannot be used or is of another stream.
  ChunkJournal(const std::string& path, const StreamId& stream);
  /// Opens a file, whatever its stream.
  explicit ChunkJournal(const std::string& path);

  const StreamId& stream() const { return stream_; }
  const NumberSet& numbers() const { return numbers_; }
  std::uint64_t last() const { return last_; }  ///< the largest number; 0: none
  std::uint64_t bytes() const { return end_; }

  /// Appends with the next number and returns it. Throws std::invalid_argument if it is too long.
  std::uint64_t append(std::uint32_t key, const std::string& content);
  /// Adds a received chunk. Returns false if it is already here.
  bool add(const LinkChunk& chunk);
  /// Nothing if it is not here. The content of a replaced chunk is empty.
  std::optional<LinkChunk> get(std::uint64_t number);

 private:
  struct Entry {
    std::uint64_t offset;
    std::uint32_t bytes, key;
  };

  void open(bool must_exist);
  void openUnnamed();
  void readAll();
  bool readRecord(std::uint64_t size);
  void note(const LinkChunk& chunk, std::uint64_t offset);
  std::string header() const;
  bool readHeader(std::uint64_t size);
  std::string readAt(std::uint64_t offset, std::size_t bytes);
  void write(const std::string& bytes);

  std::string path_;
  StreamId stream_;
  std::fstream file_;
  std::uint64_t end_ = 0;
  std::map<std::uint64_t, Entry> entries_;
  std::map<std::uint32_t, std::uint64_t> newest_of_key_;
  NumberSet numbers_;
  std::uint64_t last_ = 0;
};

}  // namespace kestrel
