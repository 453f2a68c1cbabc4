// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/session_link.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

/// Without an answer for so long, only offers are sent.
constexpr double kSilent_s = 5.0;

}  // namespace

void LinkSender::addStream(std::shared_ptr<ChunkJournal> journal) {
  const StreamId id = journal->stream();
  streams_[id].journal = std::move(journal);
}

std::optional<std::string> LinkSender::next(double now_s) {
  const double since = now_s - filled_s_.value_or(now_s - 1.0);
  tokens_ = std::min(tokens_ + since * config_.bytes_per_s, config_.bytes_per_s);
  filled_s_ = now_s;
  if (tokens_ <= 0.0) return std::nullopt;
  for (auto& [id, stream] : streams_) {
    if (auto message = offer(stream, now_s)) return message;
  }
  // A peer of another version still gets offers: it may be updated.
  if (!hears(now_s) || other_version_ != 0) return std::nullopt;
  return chunk(now_s);
}

bool LinkSender::hears(double now_s) const { return heard_s_ && now_s - *heard_s_ <= kSilent_s; }

std::optional<std::string> LinkSender::offer(Stream& stream, double now_s) {
  const std::uint64_t last = stream.journal->last();
  if (last == 0) return std::nullopt;
  const double interval = hears(now_s) ? config_.offer_s : 0.25 * config_.offer_s;
  if (stream.offered_s && now_s - *stream.offered_s < interval) return std::nullopt;
  stream.offered_s = now_s;
  stream.offered = last;
  LinkMessage message;
  message.kind = LinkMessage::Kind::kOffer;
  message.stream = stream.journal->stream();
  message.last = last;
  std::string bytes = encode(message);
  tokens_ -= static_cast<double>(bytes.size());
  return bytes;
}

/// The newest chunk that the peer does not have and that is not on the way; 0: none.
std::uint64_t LinkSender::newestMissing(Stream& stream, double now_s) const {
  for (auto at = stream.waiting.begin(); at != stream.waiting.end();)
    at = now_s - at->second >= config_.resend_s ? stream.waiting.erase(at) : std::next(at);
  if (stream.waiting.size() >= config_.window) return 0;
  std::uint64_t number = stream.received.highestMissing(stream.journal->last());
  while (number > 0 && stream.waiting.count(number) > 0)
    number = stream.received.highestMissing(number - 1);
  return number;
}

/// The chunk with the fewest newer ones in its stream, so that the newest of every stream is sent
/// before the old ones of any.
std::optional<std::string> LinkSender::chunk(double now_s) {
  Stream* chosen = nullptr;
  std::uint64_t number = 0, newer = 0;
  for (auto& [id, stream] : streams_) {
    const std::uint64_t newest = newestMissing(stream, now_s);
    if (newest == 0) continue;
    if (chosen != nullptr && stream.journal->last() - newest >= newer) continue;
    chosen = &stream;
    number = newest;
    newer = stream.journal->last() - newest;
  }
  if (chosen == nullptr) return std::nullopt;
  const std::optional<LinkChunk> content = chosen->journal->get(number);
  if (!content) return std::nullopt;
  chosen->waiting[number] = now_s;
  LinkMessage message;
  message.kind = LinkMessage::Kind::kChunk;
  message.stream = chosen->journal->stream();
  message.chunk = *content;
  std::string bytes = encode(message);
  tokens_ -= static_cast<double>(bytes.size());
  return bytes;
}

void LinkSender::receive(const LinkMessage& message, double now_s) {
  heard_s_ = now_s;
  if (message.kind == LinkMessage::Kind::kOtherVersion) other_version_ = message.version;
  if (message.kind != LinkMessage::Kind::kReceived) return;
  const auto found = streams_.find(message.stream);
  if (found == streams_.end()) return;
  other_version_ = 0;
  Stream& stream = found->second;
  // An older answer may come later. A receiver that was restarted may have lost its journal.
  if (message.receiver != stream.receiver) stream.received = NumberSet();
  stream.receiver = message.receiver;
  for (const auto& [first, last] : message.ranges) stream.received.insert(first, last);
  for (auto at = stream.waiting.begin(); at != stream.waiting.end();)
    at = stream.received.contains(at->first) ? stream.waiting.erase(at) : std::next(at);
}

std::uint64_t LinkSender::missing() const {
  std::uint64_t missing = 0;
  for (const auto& [id, stream] : streams_) {
    missing += stream.journal->last();
    for (const auto& [first, last] : stream.received.ranges())
      missing -= std::min(last, stream.journal->last()) + 1 - first;
  }
  return missing;
}

void LinkReceiver::addStream(std::shared_ptr<ChunkJournal> journal) {
  const StreamId id = journal->stream();
  streams_[id] = std::move(journal);
}

ChunkJournal* LinkReceiver::journalOf(const StreamId& stream) {
  if (local_.count(stream.vehicle) > 0) {
    ++refused_["a peer sends the vehicle " + stream.vehicle + ", which is on this host"];
    return nullptr;
  }
  const auto found = streams_.find(stream);
  if (found != streams_.end()) return found->second.get();
  if (streams_.size() >= config_.max_streams) {
    ++refused_["too many streams"];
    return nullptr;
  }
  return (streams_[stream] = open_(stream)).get();
}

std::uint64_t LinkReceiver::bytes() const {
  std::uint64_t sum = 0;
  for (const auto& [id, journal] : streams_) sum += journal->bytes();
  return sum;
}

std::optional<std::string> LinkReceiver::receive(const LinkMessage& message) {
  LinkMessage answer;
  answer.kind = LinkMessage::Kind::kOtherVersion;
  if (message.kind == LinkMessage::Kind::kOtherVersion) {
    ++refused_["another version of the protocol"];
    return encode(answer);
  }
  if (message.kind == LinkMessage::Kind::kReceived) return std::nullopt;
  ChunkJournal* journal = journalOf(message.stream);
  if (journal == nullptr) return std::nullopt;
  if (message.kind == LinkMessage::Kind::kChunk) {
    if (journal->bytes() > config_.max_stream_bytes || bytes() > config_.max_bytes) {
      ++refused_["too much data"];
      return std::nullopt;
    }
    if (!journal->add(message.chunk)) {
      ++duplicates_;
    } else if (on_chunk && !message.chunk.content.empty()) {
      on_chunk(message.stream, message.chunk);
    }
  }
  answer.kind = LinkMessage::Kind::kReceived;
  answer.stream = message.stream;
  answer.receiver = number_;
  for (const auto& range : journal->numbers().ranges()) answer.ranges.push_back(range);
  return encode(answer);
}

}  // namespace kestrel
