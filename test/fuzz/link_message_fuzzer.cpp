// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzzer.h"
#include "kestrel_slam/link/link_message.h"
#include "kestrel_slam/link/session_link.h"

namespace kestrel::fuzz {

/// Bytes that a peer sends. Whatever decodes is given to both ends.
KESTREL_FUZZER(link_message, bytes) {
  const std::optional<LinkMessage> message = decode(bytes);
  if (!message) return;
  if (message->kind != LinkMessage::Kind::kOtherVersion) FUZZ_CHECK(encode(*message) == bytes);
  LinkReceiver receiver([](const StreamId& id) { return std::make_shared<ChunkJournal>("", id); });
  receiver.receive(*message);
  LinkSender sender;
  sender.receive(*message, 1.0);
  sender.next(1.0);
}

}  // namespace kestrel::fuzz
