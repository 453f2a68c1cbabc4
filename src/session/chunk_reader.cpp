// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "chunk_format.h"
#include "file_bytes.h"
#include "kestrel_slam/session/chunk_file.h"

namespace kestrel {

using namespace chunk_format;

std::string Chunk::describe(std::size_t number) const {
  std::string name = tag;
  for (char& c : name) c = std::isprint(static_cast<unsigned char>(c)) != 0 ? c : '?';
  return "chunk " + std::to_string(number) + " (" + name + ") at byte " + std::to_string(offset);
}

ChunkReader::ChunkReader(const std::string& bytes) : bytes_(bytes) {
  if (bytes_.compare(0, kMagicBytes, kMagic, kMagicBytes) != 0) {
    throw std::runtime_error("it is not a session of kestrel_slam");
  }
  if (!readHeader()) {
    damage_.push_back("its header at byte 0 is damaged");
    findFirstChunk();
  }
  readChunks();
}

/// False if it is damaged.
bool ChunkReader::readHeader() {
  if (bytes_.size() < kFixedHeaderBytes) return false;
  container_version_ = static_cast<std::uint32_t>(numberAt(bytes_, kMagicBytes, 4));
  const std::uint64_t length = numberAt(bytes_, kMagicBytes + 4, 4);
  const std::uint64_t end = kFixedHeaderBytes + length;
  if (length > kMaxWriterBytes || end + kChecksumBytes > bytes_.size() ||
      numberAt(bytes_, end, kChecksumBytes) != checksumOf(bytes_, 0, end)) {
    return false;
  }
  writer_ = bytes_.substr(kFixedHeaderBytes, length);
  if (container_version_ > kContainerVersion) {
    throw std::runtime_error("it has the newer format " + std::to_string(container_version_) +
                             "; read it with " + writer_);
  }
  first_chunk_ = end + kChecksumBytes;
  return true;
}

/// The first place behind the shortest header where a whole chunk is.
void ChunkReader::findFirstChunk() {
  container_version_ = kContainerVersion;
  const std::uint64_t last = kFixedHeaderBytes + kMaxWriterBytes + kChecksumBytes;
  first_chunk_ = kFixedHeaderBytes + kChecksumBytes;
  while (first_chunk_ <= last && !isWhole(chunkAt(first_chunk_))) ++first_chunk_;
  if (first_chunk_ > last) {
    throw std::runtime_error("its header at byte 0 is damaged; nothing of it can be read");
  }
}

void ChunkReader::readChunks() {
  std::uint64_t offset = first_chunk_;
  while (readChunk(offset)) {
  }
}

/// What the head of the chunk says. Not all bytes of it need to be there.
Chunk ChunkReader::chunkAt(std::uint64_t offset) const {
  if (offset > bytes_.size() || bytes_.size() - offset < kHeadBytes) return {{}, 0, offset, 0, 0};
  return {bytes_.substr(offset, kTagBytes),
          static_cast<std::uint32_t>(numberAt(bytes_, offset + kTagBytes, 4)), offset,
          numberAt(bytes_, offset + kTagBytes + 4, 8),
          numberAt(bytes_, offset + kTagBytes + 12, 8)};
}

/// Whether the file is as long as the head of the chunk says.
bool ChunkReader::fits(const Chunk& chunk) const {
  return !chunk.tag.empty() &&
         chunk.packed_bytes <=
             std::min(bytes_.size() - chunk.offset - kHeadBytes, kMaxPackedBytes) &&
         chunk.content_bytes <= ChunkWriter::kMaxContentBytes;
}

bool ChunkReader::isWhole(const Chunk& chunk) const {
  return fits(chunk) && numberAt(bytes_, chunk.offset + kCheckedHeadBytes, kChecksumBytes) ==
                            checksumOf(bytes_, chunk.offset, kCheckedHeadBytes,
                                       chunk.offset + kHeadBytes, chunk.packed_bytes);
}

/// Reads one chunk and moves `offset` to the next one. False: the file ends here, or nobody knows
/// where the next chunk begins.
bool ChunkReader::readChunk(std::uint64_t& offset) {
  const std::size_t number = seen_++;
  const Chunk chunk = chunkAt(offset);
  if (chunk.tag.empty()) {
    damage_.push_back("the file ends at byte " + std::to_string(bytes_.size()) + " before chunk " +
                      std::to_string(number) + " is complete");
    return false;
  }
  if (!fits(chunk)) {
    damage_.push_back(chunk.describe(number) + " is longer than the file, or cut off");
    return false;
  }
  offset += kHeadBytes + chunk.packed_bytes;
  if (!isWhole(chunk)) {
    damage_.push_back(chunk.describe(number) + " has a wrong checksum");
  } else if (chunk.tag == kTableTag) {
    readEnd(chunk, offset);
    return false;
  } else {
    chunks_.push_back(chunk);
  }
  return true;
}

bool ChunkReader::contains(const Chunk& chunk, const std::string& expected) const {
  try {
    return content(chunk) == expected;
  } catch (const std::runtime_error&) {
    return false;
  }
}

void ChunkReader::readEnd(const Chunk& table, std::uint64_t offset) {
  const std::string place = " at byte " + std::to_string(offset);
  if (damage_.empty() && !contains(table, tableOf(chunks_))) {
    damage_.push_back("its table of contents" + place + " does not fit its chunks");
  } else if (bytes_.size() - offset != kChecksumBytes) {
    damage_.push_back("its end" + place + " is cut off, or other bytes follow");
  } else if (damage_.empty() &&
             numberAt(bytes_, offset, kChecksumBytes) != checksumOf(bytes_, 0, offset)) {
    damage_.push_back("the checksum of the whole file" + place + " is wrong");
  }
}

std::string ChunkReader::content(const Chunk& chunk) const {
  return unpack(bytes_.data() + chunk.offset + kHeadBytes, chunk.packed_bytes, chunk.content_bytes);
}

}  // namespace kestrel
