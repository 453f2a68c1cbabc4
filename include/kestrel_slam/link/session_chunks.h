// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "kestrel_slam/link/chunk_journal.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

/// A number that all states of one growing session have in common, and other sessions have not.
std::uint64_t epochOf(const Session& session);

/// Cuts a growing session into chunks. Keyframes never change, and each travels once. Submaps,
/// poses and loops change: they are in chunks that replace those before. They are written again
/// when the session has grown by a fifth, so that the traffic stays proportional to the keyframes.
class SessionCutter {
 public:
  /// Goes on after the chunks that are in the journal already.
  explicit SessionCutter(ChunkJournal& journal);

  /// Appends what is new. `whole`: also the newest poses, however little has changed.
  void update(const Session& session, bool whole = false);

 private:
  void appendKeyframes(const Session& session);
  void appendPoses(const std::string& poses);

  ChunkJournal& journal_;
  std::set<std::uint64_t> sent_;    ///< ids of keyframes
  std::size_t keyframes_then_ = 0;  ///< when the poses were written the last time
  bool odd_ = false;                ///< which keys the parts of the poses had then
};

/// The session as far as its chunks are here. Keyframes that are newer than the poses keep their
/// motion from the keyframe before. Empty without chunks. Chunks that are not a session are
/// skipped and counted in `damaged`.
Session assembledSession(ChunkJournal& journal, std::size_t* damaged = nullptr);

}  // namespace kestrel
