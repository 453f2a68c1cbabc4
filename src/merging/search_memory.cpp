// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/search_memory.h"

#include <xxhash.h>

#include <cstring>
#include <exception>

#include "kestrel_slam/session/chunk_file.h"

namespace kestrel {
namespace {

constexpr char kParametersTag[] = "PARM", kResultsTag[] = "RSLT";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kEntryBytes = sizeof(SearchMemory::Key) + sizeof(SearchMemory::Numbers);
constexpr std::size_t kEntriesPerChunk = ChunkWriter::kMaxContentBytes / kEntryBytes;

}  // namespace

const SearchMemory::Numbers& SearchMemory::result(const Key& key,
                                                  const std::function<Numbers()>& search) {
  const auto found = results_.find(key);
  if (found != results_.end()) {
    found->second.used = true;
    return found->second.numbers;
  }
  ++searches_;
  return results_.emplace(key, Entry{search(), true}).first->second.numbers;
}

void SearchMemory::forgetUnused() {
  for (auto entry = results_.begin(); entry != results_.end();) {
    if (!entry->second.used) {
      entry = results_.erase(entry);
    } else {
      entry->second.used = false;
      ++entry;
    }
  }
}

std::string SearchMemory::encode(const std::string& parameters) const {
  ChunkWriter writer("kestrel_slam");
  writer.add(kParametersTag, kVersion, parameters);
  std::string content;
  std::size_t count = 0;
  for (const auto& [key, entry] : results_) {
    content.append(reinterpret_cast<const char*>(key.data()), sizeof key);
    content.append(reinterpret_cast<const char*>(entry.numbers.data()), sizeof entry.numbers);
    if (++count % kEntriesPerChunk != 0) continue;
    writer.add(kResultsTag, kVersion, content);
    content.clear();
  }
  writer.add(kResultsTag, kVersion, content);
  return writer.finish();
}

void SearchMemory::decode(const std::string& bytes, const std::string& parameters) {
  try {
    const ChunkReader reader(bytes);
    if (!reader.damage().empty() || reader.chunks().empty()) return;
    if (reader.content(reader.chunks().front()) != parameters) return;
    for (const Chunk& chunk : reader.chunks()) {
      if (chunk.tag != kResultsTag || chunk.schema_version != kVersion) continue;
      const std::string content = reader.content(chunk);
      for (std::size_t at = 0; at + kEntryBytes <= content.size(); at += kEntryBytes) {
        Key key;
        Entry entry;
        std::memcpy(key.data(), content.data() + at, sizeof key);
        std::memcpy(entry.numbers.data(), content.data() + at + sizeof key, sizeof entry.numbers);
        results_.emplace(key, entry);
      }
    }
  } catch (const std::exception&) {
    results_.clear();  // it is searched again
  }
}

void KeyMaker::add(const std::string& text) {
  add(static_cast<std::uint64_t>(text.size()));
  bytes_ += text;
}

SearchMemory::Key KeyMaker::key() const {
  const XXH128_hash_t hash = XXH3_128bits(bytes_.data(), bytes_.size());
  return {hash.high64, hash.low64};
}

}  // namespace kestrel
