// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "chunk_format.h"
#include "file_bytes.h"
#include "kestrel_slam/session/chunk_file.h"

namespace kestrel {

ChunkWriter::ChunkWriter(const std::string& writer) {
  const std::string name = writer.substr(0, chunk_format::kMaxWriterBytes);
  bytes_ = std::string(chunk_format::kMagic, chunk_format::kMagicBytes);
  appendNumber(bytes_, chunk_format::kContainerVersion, 4);
  appendNumber(bytes_, name.size(), 4);
  bytes_ += name;
  appendNumber(bytes_, checksumOf(bytes_, 0, bytes_.size()), 8);
}

void ChunkWriter::add(const std::string& tag, std::uint32_t schema_version,
                      const std::string& content) {
  if (tag.size() != chunk_format::kTagBytes || tag == chunk_format::kTableTag) {
    throw std::invalid_argument("a chunk cannot have the tag '" + tag + "'");
  }
  if (content.size() > kMaxContentBytes) {
    throw std::invalid_argument("chunk " + tag + " has " + std::to_string(content.size()) +
                                " bytes; divide it into several");
  }
  append(tag, schema_version, content);
}

void ChunkWriter::append(const std::string& tag, std::uint32_t schema_version,
                         const std::string& content) {
  const std::string packed = pack(content);
  chunks_.push_back({tag, schema_version, bytes_.size(), packed.size(), content.size()});
  const std::uint64_t start = bytes_.size();
  bytes_ += tag;
  appendNumber(bytes_, schema_version, 4);
  appendNumber(bytes_, packed.size(), 8);
  appendNumber(bytes_, content.size(), 8);
  std::string checked = bytes_.substr(start) + packed;
  appendNumber(bytes_, checksumOf(checked, 0, checked.size()), 8);
  bytes_ += packed;
}

std::string ChunkWriter::finish() {
  append(chunk_format::kTableTag, chunk_format::kContainerVersion, chunk_format::tableOf(chunks_));
  appendNumber(bytes_, checksumOf(bytes_, 0, bytes_.size()), chunk_format::kChecksumBytes);
  return std::move(bytes_);
}

}  // namespace kestrel
