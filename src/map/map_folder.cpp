// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "map_files.h"
#include "output_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMapName = "map";
constexpr const char* kFolderEnding = ".folder";
constexpr int kMaxNames = 1000;

/// A new folder beside `place`. It is removed with this object, with what it then holds.
class FolderBeside {
 public:
  explicit FolderBeside(const fs::path& place) {
    for (int n = 0; n < kMaxNames; ++n) {
      path_ = place.parent_path() / OutputFolder::temporaryName(n, kFolderEnding);
      created_ = ::mkdir(path_.c_str(), S_IRWXU) == 0;
      if (created_ || errno != EEXIST) return;
    }
  }
  ~FolderBeside() {
    std::error_code ignored;
    if (created_) fs::remove_all(path_, ignored);
  }
  FolderBeside(const FolderBeside&) = delete;
  FolderBeside& operator=(const FolderBeside&) = delete;

  bool created() const { return created_; }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  bool created_ = false;
};

/// A folder that its process has not locked was left by a process that was killed.
void removeIfStale(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) return;
  std::error_code ignored;
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) fs::remove_all(folder, ignored);
  ::close(file);
}

void removeStaleFolders(const fs::path& parent) {
  std::error_code error;
  for (fs::directory_iterator entry(parent, error), end; !error && entry != end;
       entry.increment(error)) {
    if (OutputFolder::isTemporary(entry->path().filename().string(), kFolderEnding)) {
      removeIfStale(entry->path());
    }
  }
}

bool isFileOrLink(const fs::directory_entry& entry) {
  std::error_code error;
  const fs::file_status status = entry.symlink_status(error);
  return fs::is_regular_file(status) || fs::is_symlink(status);
}

/// Whether the folder holds only files that will be written again, or that a killed process left.
bool holdsOnly(const fs::path& folder, const std::set<std::string>& names) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const bool known =
        names.count(name) > 0 || OutputFolder::isTemporary(name, OutputFolder::kFileEnding);
    if (!known || !isFileOrLink(*entry)) return false;
  }
  return !error;
}

/// The shell that started this process would be left in a folder that is gone.
bool isWorkingFolder(const fs::path& place) {
  std::error_code error;
  const fs::path working = fs::current_path(error);
  const auto [end, rest] =
      std::mismatch(place.begin(), place.end(), working.begin(), working.end());
  return error || end == place.end();
}

/// Gives the new folder owner and permissions of the old one.
bool copyOwner(const fs::path& from, const fs::path& to) {
  struct stat old {};
  return ::stat(from.c_str(), &old) == 0 && ::chown(to.c_str(), old.st_uid, old.st_gid) == 0 &&
         ::chmod(to.c_str(), old.st_mode) == 0;
}

void writeFiles(OutputFolder& folder, const MapFiles& map,
                const std::vector<NamedContent>& others) {
  writeMapFiles(folder, kMapName, map);
  for (const NamedContent& file : others) folder.write(file.name, file.content);
}

bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

bool mayReplace(const fs::path& place, const std::vector<NamedContent>& others) {
  std::set<std::string> names = namesOfMap(kMapName);
  for (const NamedContent& file : others) names.insert(file.name);
  return ::access(place.c_str(), W_OK | X_OK) == 0 && !isWorkingFolder(place) &&
         holdsOnly(place, names);
}

/// Returns false if the folder cannot be replaced as a whole.
bool replaceFolder(const fs::path& place, const MapFiles& map,
                   const std::vector<NamedContent>& others) {
  const HeldSignals signals;
  removeStaleFolders(place.parent_path());
  const FolderBeside beside(place);
  if (!beside.created() || !copyOwner(place, beside.path())) return false;
  OutputFolder folder(beside.path().string());  // locks it until it has taken its place
  try {
    writeFiles(folder, map, others);
  } catch (const std::runtime_error&) {
    return false;
  }
  if (!exchange(beside.path(), place)) return false;
  OutputFolder::sync(place.parent_path().string());
  return true;
}

}  // namespace

void writeMapFolder(const std::string& folder, const MapSnapshot& map,
                    const std::vector<NamedContent>& others) {
  const MapFiles files = mapFilesOf((fs::path(folder) / kMapName).string(), map);
  std::error_code error;
  const fs::path place = fs::canonical(folder, error);
  if (!error && mayReplace(place, others) && replaceFolder(place, files, others)) return;
  OutputFolder in_place(folder);
  writeFiles(in_place, files, others);
}

void requireWritable(const std::string& folder) {
  OutputFolder(folder).requireWritable(std::string(kMapName) + ".yaml");
}

}  // namespace kestrel
