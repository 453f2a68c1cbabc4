// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/atomic_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "output_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void failRead(const std::string& path, const std::string& reason) {
  throw std::runtime_error("cannot read " + path + ": " + reason);
}

/// Opening a pipe waits until somebody writes to it, and a device may never end.
void requirePlainFile(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) failRead(path, std::strerror(EISDIR));
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    failRead(path, "it is a pipe, socket or device; use a plain file");
  }
}

}  // namespace

void writeFileAtomically(const std::string& path, const std::string& content) {
  const fs::path target(path);
  if (!target.has_filename()) {
    throw std::runtime_error("cannot write '" + path + "': it does not name a file");
  }
  OutputFolder(target.parent_path().string()).write(target.filename().string(), content);
}

std::string readFile(const std::string& path) {
  requirePlainFile(path);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) failRead(path, std::strerror(errno));
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace kestrel
