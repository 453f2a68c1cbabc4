// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_index.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "bag_records.h"
#include "unpacked_bag.h"

namespace kestrel {
namespace {

class IndexReader : private BagRecords {
 public:
  using BagRecords::BagRecords;

  BagIndex read();

 private:
  void addConnection(const BagRecord& connection);
  void addChunk(const BagRecord& chunk);
  double time(const BagRecord& chunk, const std::string& field) const;

  BagIndex index_;
  std::map<std::uint64_t, std::string> names_;  ///< of the topics, by connection
  std::size_t messages_ = 0;
};

BagIndex IndexReader::read() {
  if (!isBag()) throw std::runtime_error("is no bag of format 2.0");
  const BagRecord header = readHeader();
  const auto encryptor = header.fields.find("encryptor");
  if (encryptor != header.fields.end() && !encryptor->second.empty())
    throw std::runtime_error("is encrypted");
  const std::uint64_t begin = number(header, "index_pos", sizeof(std::uint64_t));
  if (begin < header.end || begin > size()) throw std::runtime_error("has no index");
  index_.begin = std::numeric_limits<double>::infinity();
  for (std::uint64_t at = begin; at < size();) {
    const BagRecord record = readRecord(at, size());
    if (record.is(kConnection)) addConnection(record);
    if (record.is(kChunkInfo)) addChunk(record);
    at = record.end;
  }
  if (messages_ == 0) throw std::runtime_error("has no messages");
  return index_;
}

void IndexReader::addConnection(const BagRecord& connection) {
  const std::string bytes =
      readBytes(connection.data_begin, connection.end - connection.data_begin);
  auto fields = fieldsOf(bytes, connection.data_begin);
  const auto name = connection.fields.find("topic");
  if (name == connection.fields.end()) fail(connection.start);
  names_[number(connection, "conn", sizeof(std::uint32_t))] = name->second;
  BagTopic& topic = index_.topics[name->second];
  topic.type = fields["type"];
  topic.md5 = fields["md5sum"];
}

/// The data are pairs of a connection and the number of its messages.
void IndexReader::addChunk(const BagRecord& chunk) {
  const std::string bytes = readBytes(chunk.data_begin, chunk.end - chunk.data_begin);
  for (std::size_t at = 0; at + 2 * sizeof(std::uint32_t) <= bytes.size();
       at += 2 * sizeof(std::uint32_t)) {
    std::uint32_t pair[2];
    std::memcpy(pair, bytes.data() + at, sizeof pair);
    const auto name = names_.find(pair[0]);
    if (name == names_.end()) fail(chunk.start);
    index_.topics[name->second].messages += pair[1];
    messages_ += pair[1];
  }
  index_.begin = std::min(index_.begin, time(chunk, "start_time"));
  index_.end = std::max(index_.end, time(chunk, "end_time"));
}

double IndexReader::time(const BagRecord& chunk, const std::string& field) const {
  const std::uint64_t value = number(chunk, field, sizeof(std::uint64_t));
  return static_cast<double>(value & 0xFFFFFFFFU) + 1e-9 * static_cast<double>(value >> 32U);
}

}  // namespace

BagIndex readBagIndex(const std::string& path) {
  const UnpackedBag content(path, {});
  return IndexReader(content.path()).read();
}

}  // namespace kestrel
