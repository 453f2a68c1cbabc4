// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/link/chunk_journal.h"

namespace kestrel {

/// What two hosts send each other. Every message has a protocol version and a checksum.
struct LinkMessage {
  enum class Kind : std::uint8_t {
    kOffer = 1,        ///< the sender has the chunks 1 to `last` of the stream
    kChunk = 2,        ///< one of them
    kReceived = 3,     ///< the receiver has these ranges of numbers
    kOtherVersion = 4  ///< the receiver speaks another version of the protocol
  };
  Kind kind = Kind::kOffer;
  StreamId stream;
  std::uint64_t last = 0;
  LinkChunk chunk;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  std::uint64_t receiver = 0;  ///< of kReceived: another number after each start of the receiver
  std::uint16_t version = 0;   ///< of whoever sent it
};

constexpr std::uint16_t kLinkVersion = 1;
/// Longer messages are refused without reading them.
constexpr std::size_t kMaxLinkMessage = ChunkJournal::kMaxContentBytes + 1024;

/// A name of a vehicle becomes a part of file names and topics: letters, digits, '_', '-' and '.',
/// up to 64, the first one a letter or digit.
bool isVehicleName(const std::string& name);

std::string encode(const LinkMessage& message);

/// Nothing if the bytes are damaged or no message. Of a message of another version only `version`
/// is read, and its kind is kOtherVersion.
std::optional<LinkMessage> decode(const std::string& bytes);

}  // namespace kestrel
