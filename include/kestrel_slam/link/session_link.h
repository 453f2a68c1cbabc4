// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "kestrel_slam/link/chunk_journal.h"
#include "kestrel_slam/link/link_message.h"

namespace kestrel {

struct LinkConfig {
  double bytes_per_s = 200e3;    ///< limit of the traffic to one peer
  std::size_t window = 64;       ///< chunks that are on the way at once
  double resend_s = 1.5;         ///< a chunk is sent again if it was not acknowledged by then
  double offer_s = 2.0;          ///< time between two offers, a quarter of it while nobody answers
  std::size_t max_streams = 64;  ///< of all peers; more are refused
  /// Of a received stream, and of all.
  std::uint64_t max_stream_bytes = 1'000'000'000, max_bytes = 4'000'000'000;
};

/// Sends the local streams to one peer, newest chunks first, until it has acknowledged all. It
/// knows no socket and no clock: the caller says what time it is (s, any origin, ascending). Only
/// numbers are in memory, so that nothing grows while nobody listens.
class LinkSender {
 public:
  explicit LinkSender(const LinkConfig& config = {}) : config_(config) {}

  void addStream(std::shared_ptr<ChunkJournal> journal);

  /// The next message to send now; nothing if all was sent or the limits are reached.
  std::optional<std::string> next(double now_s);
  /// Takes an answer of the peer.
  void receive(const LinkMessage& message, double now_s);

  /// Chunks that the peer does not have yet.
  std::uint64_t missing() const;
  /// Version of a peer that cannot be spoken to; 0: none.
  std::uint16_t otherVersion() const { return other_version_; }

 private:
  struct Stream {
    std::shared_ptr<ChunkJournal> journal;
    NumberSet received;                       ///< by the peer
    std::uint64_t receiver = 0;               ///< see LinkMessage
    std::map<std::uint64_t, double> waiting;  ///< number and time of sending
    std::optional<double> offered_s;
    std::uint64_t offered = 0;
  };

  std::optional<std::string> offer(Stream& stream, double now_s);
  std::uint64_t newestMissing(Stream& stream, double now_s) const;
  std::optional<std::string> chunk(double now_s);
  bool hears(double now_s) const;

  LinkConfig config_;
  std::map<StreamId, Stream> streams_;
  double tokens_ = 0.0;
  std::optional<double> filled_s_;
  std::optional<double> heard_s_;
  std::uint16_t other_version_ = 0;
};

/// Receives the streams of all peers.
class LinkReceiver {
 public:
  /// Makes the journal of a stream that is new.
  using Open = std::function<std::shared_ptr<ChunkJournal>(const StreamId&)>;

  /// `number`: another one after each start.
  explicit LinkReceiver(Open open, const LinkConfig& config = {}, std::uint64_t number = 1)
      : open_(std::move(open)), config_(config), number_(number) {}

  /// A stream of which an earlier process has received something.
  void addStream(std::shared_ptr<ChunkJournal> journal);
  /// Names of vehicles of this host: a peer may not send them.
  void addLocal(const std::string& vehicle) { local_[vehicle] = true; }

  /// Called once for every chunk.
  std::function<void(const StreamId&, const LinkChunk&)> on_chunk;

  /// Takes an offer or a chunk. Returns the answer, if there is one.
  std::optional<std::string> receive(const LinkMessage& message);

  const std::map<StreamId, std::shared_ptr<ChunkJournal>>& streams() const { return streams_; }
  std::size_t duplicates() const { return duplicates_; }
  /// Messages that were refused, by reason.
  const std::map<std::string, std::size_t>& refused() const { return refused_; }

 private:
  ChunkJournal* journalOf(const StreamId& stream);
  std::uint64_t bytes() const;  ///< of all streams

  Open open_;
  LinkConfig config_;
  std::uint64_t number_;
  std::map<StreamId, std::shared_ptr<ChunkJournal>> streams_;
  std::map<std::string, bool> local_;
  std::size_t duplicates_ = 0;
  std::map<std::string, std::size_t> refused_;
};

}  // namespace kestrel
