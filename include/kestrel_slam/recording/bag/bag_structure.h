// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace kestrel {

/// Damage in the records of a bag.
class BagDamage : public std::runtime_error {
 public:
  BagDamage(const std::string& text, bool any_chunk)
      : std::runtime_error(text), any_chunk_(any_chunk) {}

  /// False: the damage begins before the end of the first chunk, so that no message can be saved.
  bool anyChunk() const { return any_chunk_; }

 private:
  bool any_chunk_;
};

/// Called often while a long file is read; returns true to stop.
using StopRequest = std::function<bool()>;

/// Checks that all lengths and positions in the records of a rosbag (format 2.0) are valid. The
/// rosbag library does not check them: with a few damaged bytes it allocates gigabytes or reads
/// outside of its memory. Throws BagDamage with the position of the damage. Returns the number of
/// records that contradict each other: the bag is damaged there, but can be read.
std::size_t checkBagStructure(const std::string& path);

/// True if the bag has at least one complete chunk, which `rosbag reindex` can save.
bool hasWholeChunk(const std::string& path);

/// Topic and record time (ns) of a message.
using BagMessageKey = std::pair<std::string, std::uint64_t>;

/// The messages of every compressed chunk of a bag, in the order of the file. If one of them cannot
/// be decompressed, all of them are lost.
std::vector<std::set<BagMessageKey>> compressedChunks(const std::string& path);

}  // namespace kestrel
