// SPDX-License-Identifier: BSD-3-Clause
#include "output_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>

namespace kestrel {
namespace {

constexpr const char* kPrefix = ".kestrel_slam.";
constexpr mode_t kFileMode = 0666;  // less what the umask takes away
constexpr int kMaxFolders = 1000;
// Others hold the lock for milliseconds. A process that was stopped must not stop this one.
constexpr std::chrono::milliseconds kLockRetry(5);
constexpr int kMaxLockTries = 400;

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw std::runtime_error("cannot write " + path + ": " + reason);
}

/// Writes everything to the disk, so that a power failure after the renaming loses nothing.
/// Returns 0, or the errno of the step that failed.
int writeAll(int file, const std::string& content) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t count = ::write(file, content.data() + done, content.size() - done);
    if (count < 0 && errno != EINTR) return errno;
    if (count > 0) done += static_cast<std::size_t>(count);
  }
  // Some file systems cannot do this, and say EINVAL.
  return ::fsync(file) == 0 || errno == EINVAL ? 0 : errno;
}

sigset_t endingSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaddset(&signals, signal);
  return signals;
}

}  // namespace

HeldSignals::HeldSignals() {
  const sigset_t signals = endingSignals();
  pthread_sigmask(SIG_BLOCK, &signals, &before_);
}

HeldSignals::~HeldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  folder_ = ::open(path.empty() ? "." : path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  open_error_ = folder_ < 0 ? errno : 0;
  lock();
  removeStale();
}

OutputFolder::~OutputFolder() {
  if (folder_ >= 0) ::close(folder_);
}

std::string OutputFolder::temporaryName(int n, const std::string& ending) {
  return kPrefix + std::to_string(::getpid()) + "." + std::to_string(n) + ending;
}

bool OutputFolder::isTemporary(const std::string& name, const std::string& ending) {
  return name.rfind(kPrefix, 0) == 0 && name.size() > ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

void OutputFolder::sync(const std::string& path) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

std::string OutputFolder::pathOf(const std::string& name) const {
  return path_.empty() ? name : (std::filesystem::path(path_) / name).string();
}

/// Without the lock, writing goes on: it is only needed where two processes write the same files.
void OutputFolder::lock() {
  for (int i = 0; folder_ >= 0 && i < kMaxLockTries; ++i) {
    locked_ = ::flock(folder_, LOCK_EX | LOCK_NB) == 0;
    if (locked_ || errno != EWOULDBLOCK) return;
    std::this_thread::sleep_for(kLockRetry);
  }
}

/// While this object has the lock, nobody else is writing a temporary file.
void OutputFolder::removeStale() {
  if (!locked_) return;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(path_.empty() ? "." : path_, error), end;
       !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (isTemporary(name, kFileEnding)) ::unlinkat(folder_, name.c_str(), 0);
  }
}

void OutputFolder::requireReplaceable(const std::string& name) const {
  if (folder_ < 0) fail(pathOf(name), std::strerror(open_error_));
  struct stat status {};
  if (::fstatat(folder_, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return;
  if (S_ISDIR(status.st_mode)) fail(pathOf(name), std::strerror(EISDIR));
  if (S_ISREG(status.st_mode) || S_ISLNK(status.st_mode)) return;
  fail(pathOf(name), "a pipe, socket or device has this name; choose another one");
}

/// Writes a file without a name, of which nothing is left if the process is killed, and gives it a
/// temporary name when it is whole. Returns "" where the file system cannot do this.
std::string OutputFolder::writeNameless(const std::string& content) {
  const int file = ::openat(folder_, ".", O_WRONLY | O_TMPFILE | O_CLOEXEC, kFileMode);
  if (file < 0) return "";
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  bool named = false;
  std::string temporary;
  const bool written = writeAll(file, content) == 0;
  for (int n = 0; written && !named && n < kMaxFolders; ++n) {
    temporary = temporaryName(n, kFileEnding);
    named = ::linkat(AT_FDCWD, link.c_str(), folder_, temporary.c_str(), AT_SYMLINK_FOLLOW) == 0;
    if (!named && errno != EEXIST) break;
  }
  ::close(file);
  return named ? temporary : "";
}

std::string OutputFolder::writeTemporary(const std::string& name, const std::string& content) {
  const std::string nameless = writeNameless(content);
  if (!nameless.empty()) return nameless;
  std::string temporary;
  int file = -1;
  for (int n = 0; file < 0 && n < kMaxFolders; ++n) {
    temporary = temporaryName(n, kFileEnding);
    file = ::openat(folder_, temporary.c_str(),
                    O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kFileMode);
    if (file < 0 && errno != EEXIST) break;
  }
  if (file < 0) fail(pathOf(name), std::strerror(errno));
  int error = writeAll(file, content);
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0) return temporary;
  ::unlinkat(folder_, temporary.c_str(), 0);
  fail(pathOf(name), std::strerror(error));
}

void OutputFolder::write(const std::string& name, const std::string& content) {
  requireReplaceable(name);
  const std::string temporary = writeTemporary(name, content);
  if (::renameat(folder_, temporary.c_str(), folder_, name.c_str()) != 0) {
    const int error = errno;
    ::unlinkat(folder_, temporary.c_str(), 0);
    fail(pathOf(name), std::strerror(error));
  }
  ::fsync(folder_);
}

void OutputFolder::requireWritable(const std::string& name) {
  requireReplaceable(name);
  ::unlinkat(folder_, writeTemporary(name, "").c_str(), 0);
}

void OutputFolder::remove(const std::string& name) {
  ::unlinkat(folder_, name.c_str(), 0);
  ::fsync(folder_);
}

bool OutputFolder::has(const std::string& name) const {
  struct stat status {};
  return ::fstatat(folder_, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
}

}  // namespace kestrel
