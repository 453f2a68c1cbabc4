// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/save_folder.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/map/map_path.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path, const std::string& reason) {
  throw std::runtime_error("'" + path.string() + "' is refused: " + reason);
}

fs::path homeFolder() {
  const char* home = std::getenv("HOME");
  return home == nullptr ? fs::path() : fs::path(home);
}

/// With `~` for the home folder, and without links.
fs::path resolved(const std::string& folder) {
  const bool is_home = folder == "~" || folder.compare(0, 2, "~/") == 0;
  const fs::path path =
      is_home ? homeFolder() / fs::path(folder.substr(std::min<std::size_t>(folder.size(), 2)))
              : fs::path(folder);
  return fs::weakly_canonical(fs::absolute(path));
}

/// `folder` and `path` must be normal and without links.
bool isInside(const fs::path& folder, const fs::path& path) {
  if (folder == folder.root_path()) return folder == path.root_path();
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  const bool ends_with_slash = end != folder.end() && end->empty();
  return (end == folder.end() || ends_with_slash) && rest != path.end();
}

bool isMapFile(const fs::path& yaml) {
  std::ifstream file(yaml);
  for (std::string line; std::getline(file, line);) {
    if (line.compare(0, 6, "image:") == 0) return true;
  }
  return false;
}

/// Pipes and devices would block the thread that writes, and other files would be lost.
void requireReplaceable(const fs::path& stem) {
  for (const char* extension : {".pgm", ".yaml"}) {
    fs::path file = stem;
    file += extension;
    const fs::file_status status = fs::symlink_status(file);
    if (!fs::exists(status)) continue;
    if (!fs::is_regular_file(status)) refuse(file, "it exists and is no plain file");
    if (file.extension() == ".yaml" && !isMapFile(file)) {
      refuse(file, "it exists and is no map; choose another name");
    }
  }
}

}  // namespace

SaveFolder::SaveFolder(const std::string& folder, Words words) : words_(std::move(words)) {
  if (!folder.empty()) {
    folders_ = {resolved(folder)};
    return;
  }
  folders_ = {resolved(fs::current_path().string()), resolved(fs::temp_directory_path().string())};
  if (!homeFolder().empty()) folders_.push_back(resolved(homeFolder().string()));
}

std::string SaveFolder::stemOf(const std::string& path) const {
  if (path.empty()) return mapStemOf(path);  // throws with the reason
  const bool is_relative = path[0] != '/' && path[0] != '~';
  fs::path wanted = is_relative ? folders_.front() / path : fs::path(path);
  const fs::path stem = mapStemOf(wanted.string());
  const fs::path real = fs::weakly_canonical(stem.parent_path()) / stem.filename();
  requireInside(real, is_relative);
  createFolderOf(real.string());
  requireReplaceable(real);
  return real.string();
}

std::string SaveFolder::fileOf(const std::string& path, bool create) const {
  if (path.empty() || path.back() == '/') {
    throw std::runtime_error("the path '" + path + "' has no file name");
  }
  if (path.find('\0') != std::string::npos) throw std::runtime_error("the path has a zero byte");
  const bool is_relative = path[0] != '/' && path[0] != '~';
  const fs::path wanted = is_relative ? folders_.front() / path : resolved(path);
  const fs::path real = fs::weakly_canonical(wanted);
  requireInside(real, is_relative);
  if (create) createFolderOf(real.string());
  return real.string();
}

void SaveFolder::requireInside(const fs::path& stem, bool is_relative) const {
  const auto contains = [&stem](const fs::path& folder) { return isInside(folder, stem); };
  const auto end = is_relative ? folders_.begin() + 1 : folders_.end();
  if (std::any_of(folders_.begin(), end, contains)) return;
  std::string list;
  for (auto folder = folders_.begin(); folder != end; ++folder) {
    list += (list.empty() ? "" : ", ") + folder->string();
  }
  refuse(stem, words_.rule + " inside of " + list + " (parameter ~" + words_.parameter + ")");
}

}  // namespace kestrel
