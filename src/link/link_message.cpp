// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/link_message.h"

#include <algorithm>
#include <cctype>

#include "bytes.h"

namespace kestrel {
namespace {

// magic (4 bytes), version (2), kind (1), vehicle (4 + n), epoch (8), content, checksum (8)
constexpr char kMagic[] = "KSLK";
constexpr std::size_t kMagicBytes = 4, kMaxName = 64;
constexpr std::uint64_t kMaxNumber = 1ULL << 40U;
constexpr std::size_t kMaxRanges = 1000;

void readChunk(ByteReader& reader, LinkChunk& chunk) {
  chunk.number = reader.get<std::uint64_t>();
  chunk.key = reader.get<std::uint32_t>();
  chunk.content = reader.getText(ChunkJournal::kMaxContentBytes);
}

bool readRanges(ByteReader& reader, LinkMessage& message) {
  message.receiver = reader.get<std::uint64_t>();
  const auto count = reader.get<std::uint32_t>();
  if (count > kMaxRanges) return false;
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    const auto first = reader.get<std::uint64_t>(), last = reader.get<std::uint64_t>();
    if (first == 0 || last < first || last > kMaxNumber) return false;
    message.ranges.emplace_back(first, last);
  }
  return true;
}

bool readContent(ByteReader& reader, LinkMessage& message) {
  switch (message.kind) {
    case LinkMessage::Kind::kOffer:
      message.last = reader.get<std::uint64_t>();
      return message.last <= kMaxNumber;
    case LinkMessage::Kind::kChunk:
      readChunk(reader, message.chunk);
      return message.chunk.number > 0 && message.chunk.number <= kMaxNumber;
    case LinkMessage::Kind::kReceived:
      return readRanges(reader, message);
    case LinkMessage::Kind::kOtherVersion:
      return true;
  }
  return false;
}

void putContent(std::string& bytes, const LinkMessage& message) {
  if (message.kind == LinkMessage::Kind::kOffer) put(bytes, message.last);
  if (message.kind == LinkMessage::Kind::kChunk) {
    put(bytes, message.chunk.number);
    put(bytes, message.chunk.key);
    putText(bytes, message.chunk.content);
  }
  if (message.kind != LinkMessage::Kind::kReceived) return;
  // The highest ranges: what is sent twice because of a lower one that is left out does no harm.
  const std::size_t count = std::min(message.ranges.size(), kMaxRanges);
  put(bytes, message.receiver);
  put(bytes, static_cast<std::uint32_t>(count));
  for (std::size_t i = message.ranges.size() - count; i < message.ranges.size(); ++i) {
    put(bytes, message.ranges[i].first);
    put(bytes, message.ranges[i].second);
  }
}

}  // namespace

bool isVehicleName(const std::string& name) {
  const auto isWord = [](unsigned char c) { return std::isalnum(c) != 0; };
  if (name.empty() || name.size() > kMaxName || !isWord(name.front())) return false;
  return std::all_of(name.begin(), name.end(), [&](unsigned char c) {
    return isWord(c) || c == '_' || c == '-' || c == '.';
  });
}

std::string encode(const LinkMessage& message) {
  std::string bytes(kMagic, kMagicBytes);
  put(bytes, kLinkVersion);
  put(bytes, static_cast<std::uint8_t>(message.kind));
  putText(bytes, message.stream.vehicle);
  put(bytes, message.stream.epoch);
  putContent(bytes, message);
  put(bytes, checksumOf(bytes));
  return bytes;
}

std::optional<LinkMessage> decode(const std::string& bytes) {
  if (bytes.size() > kMaxLinkMessage || bytes.size() < kMagicBytes + 2 + kChecksumBytes)
    return std::nullopt;
  const std::string body = bytes.substr(0, bytes.size() - kChecksumBytes);
  if (ByteReader(bytes, body.size()).get<std::uint64_t>() != checksumOf(body)) return std::nullopt;
  if (body.compare(0, kMagicBytes, kMagic) != 0) return std::nullopt;
  ByteReader reader(body, kMagicBytes);
  LinkMessage message;
  message.version = reader.get<std::uint16_t>();
  message.kind = LinkMessage::Kind::kOtherVersion;
  if (message.version != kLinkVersion) return message;
  message.kind = static_cast<LinkMessage::Kind>(reader.get<std::uint8_t>());
  message.stream.vehicle = reader.getText(kMaxName);
  message.stream.epoch = reader.get<std::uint64_t>();
  const bool has_stream = message.kind != LinkMessage::Kind::kOtherVersion;
  if (has_stream && !isVehicleName(message.stream.vehicle)) return std::nullopt;
  if (!readContent(reader, message) || !reader.atEnd()) return std::nullopt;
  return message;
}

}  // namespace kestrel
