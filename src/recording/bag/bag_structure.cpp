// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_structure.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

namespace kestrel {
namespace {

// Format: http://wiki.ros.org/Bags/Format/2.0. A record consists of a header and data, each
// preceded by its length. Numbers are little-endian.
const std::string kMagic = "#ROSBAG V2.0\n";
constexpr std::uint64_t kLengthBytes = 4;
constexpr std::uint64_t kMaxHeaderBytes = 1U << 24U;
constexpr std::uint64_t kIndexEntryBytes = 12;  // time and offset
constexpr std::uint64_t kIndexTimeBytes = 8;
constexpr std::uint64_t kNanosecondsPerSecond = 1000000000;

enum Op : unsigned char {
  kMessageData = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

/// The messages of one compressed chunk, by connection.
struct ChunkIndex {
  std::map<std::uint64_t, std::set<std::uint64_t>> times;  ///< record times, ns
};

struct Record {
  std::uint64_t start = 0;
  std::map<std::string, std::string> fields;
  std::uint64_t data_begin = 0;
  std::uint64_t end = 0;

  bool is(Op op) const {
    const auto field = fields.find("op");
    return field != fields.end() && field->second == std::string(1, static_cast<char>(op));
  }
};

class Walker {
 public:
  explicit Walker(const std::string& path)
      : file_(path, std::ios::binary), size_(std::filesystem::file_size(path)) {}

  void walk();
  std::size_t contradictions() const { return contradictions_; }
  /// Walks through a bag without index as far as possible.
  bool findsWholeChunk();
  std::vector<std::set<BagMessageKey>> compressedChunks();

 private:
  Record readRecord(std::uint64_t start, std::uint64_t limit);
  void readFields(Record& record, std::uint64_t length);
  std::uint64_t readLength(std::uint64_t position, std::uint64_t limit);
  std::string readBytes(std::uint64_t position, std::uint64_t count);
  std::uint64_t number(const Record& record, const std::string& name, std::size_t bytes) const;
  Record readHeader();
  void enterChunk(const Record& chunk);
  void checkIndex(Record& index);
  void noteTimes(const Record& index, const std::string& entries);
  std::string sourceOf(const Record& message);
  void noteConnection(const Record& connection);
  void noteTopic(const Record& connection);
  void checkPosition(const Record& record, const std::string& field,
                     const std::set<std::uint64_t>& allowed) const;
  [[noreturn]] void fail(std::uint64_t position) const;

  std::ifstream file_;
  std::uint64_t size_;
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

void Walker::fail(std::uint64_t position) const {
  throw BagDamage("the bag is cut off or damaged at byte " + std::to_string(position) + " of " +
                      std::to_string(size_),
                  !chunks_.empty());
}

std::string Walker::readBytes(std::uint64_t position, std::uint64_t count) {
  std::string bytes(count, '\0');
  file_.seekg(static_cast<std::streamoff>(position));
  if (!file_.read(bytes.data(), static_cast<std::streamsize>(count))) fail(position);
  return bytes;
}

std::uint64_t Walker::readLength(std::uint64_t position, std::uint64_t limit) {
  if (position + kLengthBytes > limit) fail(position);
  std::uint32_t length = 0;
  std::memcpy(&length, readBytes(position, kLengthBytes).data(), kLengthBytes);
  if (length > limit - position - kLengthBytes) fail(position);
  return length;
}

void Walker::readFields(Record& record, std::uint64_t length) {
  const std::uint64_t begin = record.start + kLengthBytes;
  const std::string bytes = readBytes(begin, length);
  for (std::uint64_t at = 0; at < length;) {
    std::uint32_t size = 0;
    if (at + kLengthBytes > length) fail(begin + at);
    std::memcpy(&size, bytes.data() + at, kLengthBytes);
    at += kLengthBytes;
    if (size > length - at) fail(begin + at);
    const std::string field = bytes.substr(at, size);
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) fail(begin + at);
    record.fields[field.substr(0, equals)] = field.substr(equals + 1);
    at += size;
  }
}

Record Walker::readRecord(std::uint64_t start, std::uint64_t limit) {
  Record record;
  record.start = start;
  const std::uint64_t header = readLength(start, limit);
  if (header > kMaxHeaderBytes) fail(start);
  readFields(record, header);
  const std::uint64_t length_at = start + kLengthBytes + header;
  record.data_begin = length_at + kLengthBytes;
  record.end = record.data_begin + readLength(length_at, limit);
  return record;
}

std::uint64_t Walker::number(const Record& record, const std::string& name,
                             std::size_t bytes) const {
  const auto field = record.fields.find(name);
  if (field == record.fields.end() || field->second.size() != bytes) fail(record.start);
  std::uint64_t value = 0;
  std::memcpy(&value, field->second.data(), bytes);
  return value;
}

void Walker::enterChunk(const Record& chunk) {
  chunk_size_ = number(chunk, "size", sizeof(std::uint32_t));
  in_chunk_.reset();
  const auto compression = chunk.fields.find("compression");
  if (compression == chunk.fields.end()) fail(chunk.start);
  if (compression->second != "none") {
    chunks_.insert(chunk.start);
    compressed_.emplace_back();
    return;
  }
  if (chunk_size_ != chunk.end - chunk.data_begin) fail(chunk.start);
  in_chunk_.emplace();
  for (std::uint64_t at = chunk.data_begin; at < chunk.end;) {
    const Record record = readRecord(at, chunk.end);
    (*in_chunk_)[at - chunk.data_begin] = record.is(kMessageData) ? sourceOf(record) : "";
    if (record.is(kConnection)) noteConnection(record);
    at = record.end;
  }
  chunks_.insert(chunk.start);
}

void Walker::checkIndex(Record& index) {
  const std::uint64_t count = number(index, "count", sizeof(std::uint32_t));
  // Bags of 2010 give a length of 20 bytes per entry, but use 12. The library uses only the count.
  index.end = index.data_begin + count * kIndexEntryBytes;
  if (index.end > size_) fail(index.start);
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

void Walker::noteTimes(const Record& index, const std::string& entries) {
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
std::string Walker::sourceOf(const Record& message) {
  const auto connection = message.fields.find("conn"), time = message.fields.find("time");
  if (connection == message.fields.end() || time == message.fields.end()) fail(message.start);
  return connection->second + time->second;
}

/// A connection is recorded in a chunk and again at the end of the bag. Both must be equal.
void Walker::noteConnection(const Record& connection) {
  const auto topic = connection.fields.find("topic");
  const std::string content =
      (topic == connection.fields.end() ? "" : topic->second) + '\n' +
      readBytes(connection.data_begin, connection.end - connection.data_begin);
  const std::uint64_t number_of = number(connection, "conn", sizeof(std::uint32_t));
  const auto known = connections_.emplace(number_of, content).first;
  if (known->second != content) ++contradictions_;
}

void Walker::noteTopic(const Record& connection) {
  const auto topic = connection.fields.find("topic");
  if (topic == connection.fields.end()) return;
  topics_[number(connection, "conn", sizeof(std::uint32_t))] = topic->second;
}

void Walker::checkPosition(const Record& record, const std::string& field,
                           const std::set<std::uint64_t>& allowed) const {
  const std::uint64_t position = number(record, field, sizeof(std::uint64_t));
  if (allowed.count(position) == 0) fail(record.start);
}

Record Walker::readHeader() {
  Record header = readRecord(kMagic.size(), size_);
  if (!header.is(kBagHeader)) fail(header.start);
  return header;
}

bool Walker::findsWholeChunk() {
  try {
    for (std::uint64_t at = readHeader().end; at < size_ && chunks_.empty();) {
      const Record record = readRecord(at, size_);
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
  if (readBytes(0, std::min<std::uint64_t>(size_, kMagic.size())) != kMagic) return;
  const Record header = readHeader();
  const auto encryptor = header.fields.find("encryptor");
  if (encryptor != header.fields.end() && !encryptor->second.empty()) return;
  const bool indexed = number(header, "index_pos", sizeof(std::uint64_t)) != 0;
  for (std::uint64_t at = header.end; at < size_ && indexed;) {
    Record record = readRecord(at, size_);
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
  records_.insert(size_);  // the index position of a bag without messages
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
