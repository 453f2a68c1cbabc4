// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <string>

#include "kestrel_slam/recording/recording.h"

namespace kestrel::fuzz {

/// A file in memory with a path, because the readers take paths. `ending`: of its name.
class FuzzFile {
 public:
  explicit FuzzFile(const std::string& bytes, const std::string& ending = {})
      : file_(::memfd_create("fuzz", MFD_CLOEXEC)),
        path_("/proc/self/fd/" + std::to_string(file_)) {
    if (file_ < 0 || ::write(file_, bytes.data(), bytes.size()) < 0) std::abort();
    if (ending.empty()) return;
    link_ = "/tmp/kestrel_fuzz_" + std::to_string(::getpid()) + ending;
    if (::symlink(path_.c_str(), link_.c_str()) != 0) std::abort();
  }
  ~FuzzFile() {
    ::close(file_);
    if (!link_.empty()) ::unlink(link_.c_str());
  }
  FuzzFile(const FuzzFile&) = delete;
  FuzzFile& operator=(const FuzzFile&) = delete;

  const std::string& path() const { return link_.empty() ? path_ : link_; }

 private:
  int file_;
  std::string path_, link_;
};

/// Runs `action`. Readers report every problem with an exception that has a text.
template <typename Action>
void expectResultOrReason(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    if (std::string(error.what()).empty()) std::abort();
  }
}

inline void readAll(Recording& recording) {
  RecordedScan scan;
  while (recording.next(scan)) {
  }
  if (recording.description().empty()) std::abort();
}

}  // namespace kestrel::fuzz
