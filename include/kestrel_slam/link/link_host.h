// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/link/session_link.h"

namespace kestrel {

struct LinkHostConfig {
  std::string bind;                ///< "tcp://*:5601"; empty: only send
  std::vector<std::string> peers;  ///< "tcp://10.0.0.2:5601"
  std::string keys;                ///< file of makeLinkKeys(); empty: without encryption
  std::string folder;  ///< for the journals of what is received; empty: until the end only
  LinkConfig link;
};

/// Writes a new pair of CURVE keys. All hosts that may talk to each other get a copy of this file.
/// Throws std::runtime_error.
void makeLinkKeys(const std::string& path);

/// One host of a link, with ZeroMQ. Peers may come and go at any time.
class LinkHost {
 public:
  /// Takes up the journals in the folder. Throws std::runtime_error if an address or the file of
  /// keys cannot be used.
  explicit LinkHost(const LinkHostConfig& config);
  ~LinkHost();
  LinkHost(const LinkHost&) = delete;
  LinkHost& operator=(const LinkHost&) = delete;

  /// Sends the chunks of a vehicle of this host to all peers, also those that are appended later.
  void send(const std::shared_ptr<ChunkJournal>& journal);

  /// Sends and receives for some time.
  void run(double seconds);

  LinkReceiver& receiver();
  /// Chunks that some peer does not have yet.
  std::uint64_t missing() const;
  /// New problems for the user, once each.
  std::vector<std::string> takeProblems();

 private:
  struct Sockets;
  std::unique_ptr<Sockets> sockets_;
};

}  // namespace kestrel
