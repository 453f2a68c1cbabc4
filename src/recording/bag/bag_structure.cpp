// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_structure.h"

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <set>

#include "bag_records.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kIndexEntryBytes = 12;  // time and offset
constexpr std::uint64_t kIndexTimeBytes = 8;
constexpr std::uint64_t kNanosecondsPerSecond = 1000000000;

/// The messages of one compressed chunk, by connection.
struct ChunkIndex {
  std::map<std::uint64_t, std::set<std::uint64_t>> times;  ///< record times, ns
};

class Walker : private BagRecords {
 public:
  using BagRecords::BagRecords;

  void walk();
  std::size_t contradictions() const { return contradictions_; }
  /// Walks through a bag without index as far as possible.
  bool findsWholeChunk();
  std::vector<std::set<BagMessageKey>> compressedChunks();

 private:
  void noteChunk(std::uint64_t start);
  void enterChunk(const BagRecord& chunk);
  void checkIndex(BagRecord& index);
  void noteTimes(const BagRecord& index, const std::string& entries);
  std::string sourceOf(const BagRecord& message);
  void noteConnection(const BagRecord& connection);
  void noteTopic(const BagRecord& connection);
  void checkPosition(const BagRecord& record, const std::string& field,
                     const std::set<std::uint64_t>& allowed) const;

  std::set<std::uint64_t> records_, chunks_;
  std::uint64_t chunk_size_ = 0;  ///< uncompressed size of the last chunk
  /// Connection and time of the messages in the last chunk by position, if it is not compressed;
  /// other records have none.
  std::optional<std::map<std::uint64_t, std::string>> in_chunk_;
  std::map<std::uint64_t, std::string> connections_;  ///< their records in the chunks
  std::size_t contradictions_ = 0;
  std::vector<ChunkIndex> compressed_;
  std::map<std::uint64_t, std::string> topics_;  ///< by connection
};

void Walker::noteChunk(std::uint64_t start) {
  chunks_.insert(start);
  any_chunk_ = true;
}

void Walker::enterChunk(const BagRecord& chunk) {
  chunk_size_ = number(chunk, "size", sizeof(std::uint32_t));
  in_chunk_.reset();
  const auto compression = chunk.fields.find("compression");
  if (compression == chunk.fields.end()) fail(chunk.start);
  if (compression->second != "none") {
    noteChunk(chunk.start);
    compressed_.emplace_back();
    return;
  }
  if (chunk_size_ != chunk.end - chunk.data_begin) fail(chunk.start);
  in_chunk_.emplace();
  for (std::uint64_t at = chunk.data_begin; at < chunk.end;) {
    const BagRecord record = readRecord(at, chunk.end);
    (*in_chunk_)[at - chunk.data_begin] = record.is(kMessageData) ? sourceOf(record) : "";
    if (record.is(kConnection)) noteConnection(record);
    at = record.end;
  }
  noteChunk(chunk.start);
}

void Walker::checkIndex(BagRecord& index) {
  const std::uint64_t count = number(index, "count", sizeof(std::uint32_t));
  // Bags of 2010 give a length of 20 bytes per entry, but use 12. The library uses only the count.
  index.end = index.data_begin + count * kIndexEntryBytes;
  if (index.end > size()) fail(index.start);
  const std::string entries = readBytes(index.data_begin, count * kIndexEntryBytes);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t at = i * kIndexEntryBytes + kIndexTimeBytes;
    std::uint32_t offset = 0;
    std::memcpy(&offset, entries.data() + at, sizeof offset);
    if (in_chunk_ && in_chunk_->count(offset) > 0) {
      const std::string time = entries.substr(at - kIndexTimeBytes, kIndexTimeBytes);
      if (in_chunk_->at(offset) != index.fields.at("conn") + time) ++contradictions_;
    }
    const bool possible = in_chunk_ ? in_chunk_->count(offset) > 0 : offset < chunk_size_;
    if (!possible) fail(index.data_begin + at);
  }
  if (!in_chunk_ && !compressed_.empty()) noteTimes(index, entries);
}

void Walker::noteTimes(const BagRecord& index, const std::string& entries) {
  std::set<std::uint64_t>& times =
      compressed_.back().times[number(index, "conn", sizeof(std::uint32_t))];
  for (std::size_t at = 0; at + kIndexEntryBytes <= entries.size(); at += kIndexEntryBytes) {
    std::uint32_t seconds = 0, nanoseconds = 0;
    std::memcpy(&seconds, entries.data() + at, sizeof seconds);
    std::memcpy(&nanoseconds, entries.data() + at + sizeof seconds, sizeof nanoseconds);
    times.insert(seconds * kNanosecondsPerSecond + nanoseconds);
  }
}

/// Connection and time of a message, as bytes.
std::string Walker::sourceOf(const BagRecord& message) {
  const auto connection = message.fields.find("conn"), time = message.fields.find("time");
  if (connection == message.fields.end() || time == message.fields.end()) fail(message.start);
  return connection->second + time->second;
}

/// A connection is recorded in a chunk and again at the end of the bag. Both must be equal.
void Walker::noteConnection(const BagRecord& connection) {
  const auto topic = connection.fields.find("topic");
  const std::string content =
      (topic == connection.fields.end() ? "" : topic->second) + '\n' +
      readBytes(connection.data_begin, connection.end - connection.data_begin);
  const std::uint64_t number_of = number(connection, "conn", sizeof(std::uint32_t));
  const auto known = connections_.emplace(number_of, content).first;
  if (known->second != content) ++contradictions_;
}

void Walker::noteTopic(const BagRecord& connection) {
  const auto topic = connection.fields.find("topic");
  if (topic == connection.fields.end()) return;
  topics_[number(connection, "conn", sizeof(std::uint32_t))] = topic->second;
}

void Walker::checkPosition(const BagRecord& record, const std::string& field,
                           const std::set<std::uint64_t>& allowed) const {
  const std::uint64_t position = number(record, field, sizeof(std::uint64_t));
  if (allowed.count(position) == 0) fail(record.start);
}

bool Walker::findsWholeChunk() {
  try {
    for (std::uint64_t at = readHeader().end; at < size() && chunks_.empty();) {
      const BagRecord record = readRecord(at, size());
      // The recorder writes the sizes of a chunk when the chunk is complete. Until then they are 0.
      if (record.is(kChunk) && record.end > record.data_begin) enterChunk(record);
      at = record.end;
    }
  } catch (const BagDamage&) {
    return !chunks_.empty();
  }
  return !chunks_.empty();
}

std::vector<std::set<BagMessageKey>> Walker::compressedChunks() {
  walk();
  std::vector<std::set<BagMessageKey>> result;
  for (const ChunkIndex& chunk : compressed_) {
    result.emplace_back();
    for (const auto& [connection, times] : chunk.times) {
      for (const std::uint64_t time : times) result.back().emplace(topics_[connection], time);
    }
  }
  return result;
}

void Walker::walk() {
  if (!isBag()) return;
  const BagRecord header = readHeader();
  const auto encryptor = header.fields.find("encryptor");
  if (encryptor != header.fields.end() && !encryptor->second.empty()) return;
  const bool indexed = number(header, "index_pos", sizeof(std::uint64_t)) != 0;
  for (std::uint64_t at = header.end; at < size() && indexed;) {
    BagRecord record = readRecord(at, size());
    records_.insert(record.start);
    if (record.is(kChunk)) enterChunk(record);
    if (record.is(kIndexData)) checkIndex(record);
    if (record.is(kChunkInfo)) checkPosition(record, "chunk_pos", chunks_);
    if (record.is(kConnection)) {
      noteTopic(record);
      noteConnection(record);
    }
    at = record.end;
  }
  records_.insert(size());  // the index position of a bag without messages
  if (indexed) checkPosition(header, "index_pos", records_);
}

}  // namespace

std::size_t checkBagStructure(const std::string& path) {
  Walker walker(path);
  walker.walk();
  return walker.contradictions();
}

bool hasWholeChunk(const std::string& path) { return Walker(path).findsWholeChunk(); }

std::vector<std::set<BagMessageKey>> compressedChunks(const std::string& path) {
  return Walker(path).compressedChunks();
}

}  // namespace kestrel
