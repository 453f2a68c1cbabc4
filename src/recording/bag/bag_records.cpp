// SPDX-License-Identifier: BSD-3-Clause
#include "bag_records.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "kestrel_slam/recording/bag/bag_structure.h"

namespace kestrel {
namespace {

// Format: http://wiki.ros.org/Bags/Format/2.0. Numbers are little-endian.
const std::string kMagic = "#ROSBAG V2.0\n";
constexpr std::uint64_t kLengthBytes = 4;
constexpr std::uint64_t kMaxHeaderBytes = 1U << 24U;
constexpr std::size_t kReadBytes = 1U << 14U;

}  // namespace

bool BlockReader::read(std::uint64_t position, std::uint64_t count, char* bytes) {
  if (position < begin_ || position + count > begin_ + block_.size()) {
    block_.resize(std::max<std::size_t>(count, kReadBytes));
    begin_ = position;
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(position));
    file_.read(block_.data(), static_cast<std::streamsize>(block_.size()));
    block_.resize(static_cast<std::size_t>(std::max<std::streamsize>(file_.gcount(), 0)));
    if (block_.size() < count) return false;
  }
  std::memcpy(bytes, block_.data() + (position - begin_), count);
  return true;
}

BagRecords::BagRecords(const std::string& path)
    : file_(path), size_(std::filesystem::file_size(path)) {}

bool BagRecords::isBag() {
  return readBytes(0, std::min<std::uint64_t>(size_, kMagic.size())) == kMagic;
}

void BagRecords::fail(std::uint64_t position) const {
  throw BagDamage("the bag is cut off or damaged at byte " + std::to_string(position) + " of " +
                      std::to_string(size_),
                  any_chunk_);
}

std::string BagRecords::readBytes(std::uint64_t position, std::uint64_t count) {
  std::string bytes(count, '\0');
  if (!file_.read(position, count, bytes.data())) fail(position);
  return bytes;
}

std::uint64_t BagRecords::readLength(std::uint64_t position, std::uint64_t limit) {
  if (position + kLengthBytes > limit) fail(position);
  std::uint32_t length = 0;
  std::memcpy(&length, readBytes(position, kLengthBytes).data(), kLengthBytes);
  if (length > limit - position - kLengthBytes) fail(position);
  return length;
}

std::map<std::string, std::string> BagRecords::fieldsOf(const std::string& bytes,
                                                        std::uint64_t begin) const {
  std::map<std::string, std::string> fields;
  for (std::uint64_t at = 0; at < bytes.size();) {
    std::uint32_t size = 0;
    if (at + kLengthBytes > bytes.size()) fail(begin + at);
    std::memcpy(&size, bytes.data() + at, kLengthBytes);
    at += kLengthBytes;
    if (size > bytes.size() - at) fail(begin + at);
    const std::string field = bytes.substr(at, size);
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) fail(begin + at);
    fields[field.substr(0, equals)] = field.substr(equals + 1);
    at += size;
  }
  return fields;
}

BagRecord BagRecords::readRecord(std::uint64_t start, std::uint64_t limit) {
  BagRecord record;
  record.start = start;
  const std::uint64_t header = readLength(start, limit);
  if (header > kMaxHeaderBytes) fail(start);
  const std::uint64_t fields_at = start + kLengthBytes;
  record.fields = fieldsOf(readBytes(fields_at, header), fields_at);
  const std::uint64_t length_at = start + kLengthBytes + header;
  record.data_begin = length_at + kLengthBytes;
  record.end = record.data_begin + readLength(length_at, limit);
  return record;
}

std::uint64_t BagRecords::number(const BagRecord& record, const std::string& name,
                                 std::size_t bytes) const {
  const auto field = record.fields.find(name);
  if (field == record.fields.end() || field->second.size() != bytes) fail(record.start);
  std::uint64_t value = 0;
  std::memcpy(&value, field->second.data(), bytes);
  return value;
}

BagRecord BagRecords::readHeader() {
  BagRecord header = readRecord(kMagic.size(), size_);
  if (!header.is(kBagHeader)) fail(header.start);
  return header;
}

}  // namespace kestrel
