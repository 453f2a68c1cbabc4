// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/chunk_journal.h"

#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "bytes.h"

namespace kestrel {
namespace {

// header: magic (8 bytes), version (4), vehicle (4 + n), epoch (8), checksum (8)
// record: number (8), key (4), length (4), checksum of these 16 bytes and the content (8), content
constexpr char kJournalMagic[] = "KSJOURN1";
constexpr std::size_t kJournalMagicBytes = 8, kHeadBytes = 16;
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kMaxJournalName = 255;

}  // namespace

ChunkJournal::ChunkJournal(const std::string& path, const StreamId& stream)
    : path_(path), stream_(stream) {
  if (stream.vehicle.empty() || stream.vehicle.size() > kMaxJournalName)
    throw std::invalid_argument("the name of a vehicle has 1 to 255 bytes");
  if (path_.empty()) {
    openUnnamed();
  } else {
    open(false);
  }
}

ChunkJournal::ChunkJournal(const std::string& path) : path_(path) { open(true); }

/// The file stays open, but nobody finds it any more.
void ChunkJournal::openUnnamed() {
  std::string path = (std::filesystem::temp_directory_path() / "kestrel_XXXXXX").string();
  const int file = mkstemp(path.data());
  if (file < 0) throw std::runtime_error(path + ": cannot be made; set TMPDIR to another folder");
  close(file);
  path_ = path;
  open(true);
  std::filesystem::remove(path_);
}

void ChunkJournal::open(bool must_exist) {
  if (!must_exist && !std::filesystem::exists(path_)) std::ofstream(path_, std::ios::binary);
  file_.open(path_, std::ios::in | std::ios::out | std::ios::binary);
  if (!file_) throw std::runtime_error(path_ + ": cannot be opened for reading and writing");
  readAll();
}

std::string ChunkJournal::header() const {
  std::string bytes(kJournalMagic, kJournalMagicBytes);
  put(bytes, kVersion);
  putText(bytes, stream_.vehicle);
  put(bytes, stream_.epoch);
  put(bytes, checksumOf(bytes));
  return bytes;
}

bool ChunkJournal::readHeader(std::uint64_t size) {
  const std::size_t most = kJournalMagicBytes + 4 + 4 + kMaxJournalName + 8 + kChecksumBytes;
  const std::string bytes =
      readAt(0, static_cast<std::size_t>(std::min<std::uint64_t>(size, most)));
  if (bytes.compare(0, kJournalMagicBytes, kJournalMagic) != 0) return false;
  ByteReader reader(bytes, kJournalMagicBytes);
  if (reader.get<std::uint32_t>() != kVersion) return false;
  StreamId stream;
  stream.vehicle = reader.getText(kMaxJournalName);
  stream.epoch = reader.get<std::uint64_t>();
  const std::size_t length = reader.at();
  const auto checksum = reader.get<std::uint64_t>();
  if (!reader.ok() || checksum != checksumOf(bytes.substr(0, length))) return false;
  if (!stream_.vehicle.empty() && !(stream == stream_))
    throw std::runtime_error(path_ + ": is the journal of " + stream.vehicle + ", not of " +
                             stream_.vehicle + "; use another folder");
  stream_ = stream;
  end_ = length + kChecksumBytes;
  return true;
}

void ChunkJournal::readAll() {
  const std::uint64_t size = std::filesystem::file_size(path_);
  if (size == 0 && !stream_.vehicle.empty()) {
    write(header());
    return;
  }
  if (!readHeader(size))
    throw std::runtime_error(path_ + ": is not a journal; move it away, it will be made again");
  while (readRecord(size)) {
  }
  if (end_ < size) std::filesystem::resize_file(path_, end_);  // a chunk that was half written
}

bool ChunkJournal::readRecord(std::uint64_t size) {
  if (size - end_ < kHeadBytes + kChecksumBytes) return false;
  const std::string head = readAt(end_, kHeadBytes + kChecksumBytes);
  ByteReader reader(head);
  LinkChunk chunk;
  chunk.number = reader.get<std::uint64_t>();
  chunk.key = reader.get<std::uint32_t>();
  const auto length = reader.get<std::uint32_t>();
  const auto checksum = reader.get<std::uint64_t>();
  const std::uint64_t begin = end_ + head.size();
  if (length > kMaxContentBytes || length > size - begin) return false;
  chunk.content = readAt(begin, length);
  if (checksum != checksumOf(head.substr(0, kHeadBytes) + chunk.content)) return false;
  note(chunk, begin);
  end_ = begin + length;
  return true;
}

void ChunkJournal::note(const LinkChunk& chunk, std::uint64_t offset) {
  entries_[chunk.number] = {offset, static_cast<std::uint32_t>(chunk.content.size()), chunk.key};
  numbers_.insert(chunk.number);
  last_ = std::max(last_, chunk.number);
  if (chunk.key != 0) {
    std::uint64_t& newest = newest_of_key_[chunk.key];
    newest = std::max(newest, chunk.number);
  }
}

std::string ChunkJournal::readAt(std::uint64_t offset, std::size_t bytes) {
  std::string content(bytes, '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(offset));
  file_.read(content.data(), static_cast<std::streamsize>(bytes));
  content.resize(static_cast<std::size_t>(file_.gcount()));
  return content;
}

void ChunkJournal::write(const std::string& bytes) {
  file_.clear();
  file_.seekp(static_cast<std::streamoff>(end_));
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file_.flush();
  if (!file_) throw std::runtime_error(path_ + ": cannot be written; is the disk full?");
  end_ += bytes.size();
}

std::uint64_t ChunkJournal::append(std::uint32_t key, const std::string& content) {
  if (content.size() > kMaxContentBytes)
    throw std::invalid_argument("a chunk has at most " + std::to_string(kMaxContentBytes) +
                                " bytes");
  const std::uint64_t number = last_ + 1;
  add({number, key, content});
  return number;
}

bool ChunkJournal::add(const LinkChunk& chunk) {
  if (numbers_.contains(chunk.number)) return false;
  std::string bytes;
  put(bytes, chunk.number);
  put(bytes, chunk.key);
  put(bytes, static_cast<std::uint32_t>(chunk.content.size()));
  put(bytes, checksumOf(bytes + chunk.content));
  const std::uint64_t offset = end_ + bytes.size();
  write(bytes + chunk.content);
  note(chunk, offset);
  return true;
}

std::optional<LinkChunk> ChunkJournal::get(std::uint64_t number) {
  const auto found = entries_.find(number);
  if (found == entries_.end()) return std::nullopt;
  const Entry& entry = found->second;
  LinkChunk chunk{number, entry.key, ""};
  const bool replaced = entry.key != 0 && newest_of_key_[entry.key] != number;
  if (!replaced) chunk.content = readAt(entry.offset, entry.bytes);
  return chunk;
}

}  // namespace kestrel
