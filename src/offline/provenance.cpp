// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/provenance.h"

#define XXH_INLINE_ALL  // header only: there is nothing to link
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

namespace kestrel {
namespace {

class Hash {
 public:
  Hash() { XXH3_128bits_reset(state_.get()); }

  void add(const char* data, std::size_t size) { XXH3_128bits_update(state_.get(), data, size); }

  std::string text() const {
    const XXH128_hash_t value = XXH3_128bits_digest(state_.get());
    std::array<char, 33> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx%016llx",
                  static_cast<unsigned long long>(value.high64),
                  static_cast<unsigned long long>(value.low64));
    return digits.data();
  }

 private:
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_{XXH3_createState(),
                                                                  &XXH3_freeState};
};

void addFile(Hash& hash, const std::string& path) {
  constexpr std::size_t kBlock = 1U << 20U;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(kBlock);
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.add(block.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (!file.eof()) throw std::runtime_error("cannot read " + path + ": " + std::strerror(errno));
}

}  // namespace

std::string hashOfFiles(std::vector<std::string> paths) {
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::filesystem::path(a).filename() < std::filesystem::path(b).filename();
  });
  Hash hash;
  for (const std::string& path : paths) addFile(hash, path);
  return hash.text();
}

std::string hashOfText(const std::string& text) {
  Hash hash;
  hash.add(text.data(), text.size());
  return hash.text();
}

}  // namespace kestrel
