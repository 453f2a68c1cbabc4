// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_path.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDefaultName = "map";

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
  throw std::runtime_error("cannot save a map to '" + path + "': " + reason);
}

bool isControl(char c) {
  constexpr unsigned char kSpace = 0x20, kDelete = 0x7f;
  const auto byte = static_cast<unsigned char>(c);
  return byte < kSpace || byte == kDelete;
}

/// How many bytes follow the first byte of a character in UTF-8, or -1.
int followersOf(unsigned char first) {
  if (first < 0x80) return 0;
  if (first >= 0xc2 && first < 0xe0) return 1;
  if (first >= 0xe0 && first < 0xf0) return 2;
  return first >= 0xf0 && first < 0xf5 ? 3 : -1;
}

/// YAML files are UTF-8. With other bytes no parser would read them.
bool isUtf8(const std::string& text) {
  int missing = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (missing > 0) {
      if ((byte & 0xc0) != 0x80) return false;
      --missing;
    } else {
      missing = followersOf(byte);
      if (missing < 0) return false;
    }
  }
  return missing == 0;
}

std::string withoutTilde(const std::string& path) {
  if (path[0] != '~') return path;
  if (path.size() > 1 && path[1] != '/') {
    refuse(path, "only ~/ is supported; write the home folder of another user in full");
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') refuse(path, "HOME is not set; use an absolute path");
  return home + path.substr(1);
}

bool isMapExtension(const fs::path& extension) {
  return extension == ".pgm" || extension == ".yaml" || extension == ".yml";
}

}  // namespace

std::string mapStemOf(const std::string& path) {
  if (path.empty()) {
    throw std::runtime_error("the path of the map is empty; set a path such as ~/maps/office");
  }
  if (std::any_of(path.begin(), path.end(), isControl) || !isUtf8(path)) {
    throw std::runtime_error("the path of the map has a control character or is not UTF-8");
  }
  fs::path stem = fs::absolute(withoutTilde(path)).lexically_normal();
  std::error_code ignored;
  if (fs::is_directory(stem, ignored)) stem /= kDefaultName;
  if (!stem.has_filename()) stem /= kDefaultName;
  if (isMapExtension(stem.extension())) stem.replace_extension();
  return stem.string();
}

void createFolderOf(const std::string& stem) {
  const fs::path folder = fs::path(stem).parent_path();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error && !fs::is_directory(folder)) {
    refuse(stem, "the folder " + folder.string() + " cannot be created: " + error.message());
  }
}

}  // namespace kestrel
