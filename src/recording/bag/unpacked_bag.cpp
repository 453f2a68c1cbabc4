// SPDX-License-Identifier: BSD-3-Clause
#include "unpacked_bag.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <istream>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/recording/file_kind.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr std::size_t kBlock = 1U << 20U;  // bytes

void writeAll(int file, const char* bytes, std::size_t count, const std::string& source) {
  while (count > 0) {
    const ssize_t written = ::write(file, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      throw std::runtime_error(source + ": cannot be decompressed to " +
                               std::filesystem::temp_directory_path().string() + " (" +
                               std::strerror(errno) + "); decompress it yourself");
    }
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
}

/// Creates a file without a name.
int openTemporary(const std::string& source) {
  std::string name = (std::filesystem::temp_directory_path() / "kestrel_bag_XXXXXX").string();
  const int file = ::mkstemp(name.data());
  if (file < 0) writeAll(file, name.data(), 1, source);  // throws with the reason
  ::unlink(name.c_str());
  return file;
}

}  // namespace

UnpackedBag::UnpackedBag(const std::string& path, const StopRequest& stop) : path_(path) {
  if (isCompressed(path)) unpack(path, stop);
}

UnpackedBag::~UnpackedBag() {
  if (file_ >= 0) ::close(file_);
}

void UnpackedBag::unpack(const std::string& source, const StopRequest& stop) {
  const std::unique_ptr<std::istream> stream = openText(source);
  file_ = openTemporary(source);
  path_ = "/proc/self/fd/" + std::to_string(file_);
  std::vector<char> block(kBlock);
  while (*stream) {
    if (stop && stop()) throw std::runtime_error(source + ": stopped while it was decompressed");
    stream->read(block.data(), static_cast<std::streamsize>(block.size()));
    writeAll(file_, block.data(), static_cast<std::size_t>(stream->gcount()), source);
  }
  if (stream->bad()) {
    throw std::runtime_error(source +
                             ": the compressed data are damaged or cut off; copy the file again");
  }
}

}  // namespace kestrel
