// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/text_stream.h"

#include <boost/iostreams/device/file.hpp>
#include <boost/iostreams/filter/bzip2.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filter/lzma.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <streambuf>

#include "affixes.h"

namespace kestrel {
namespace {

constexpr std::size_t kCompressionBytes = 6;
const std::string kBzip2Magic = "BZh";
const std::string kGzipMagic = "\x1f\x8b";
const std::string kXzMagic("\xfd\x37zXZ\0", 6);

void requireFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw std::runtime_error(path + ": the file does not exist; check the path");
  }
  if (std::filesystem::is_directory(path, error)) {
    throw std::runtime_error(path + ": is a folder, not a file");
  }
  if (!std::filesystem::is_regular_file(path, error)) {
    throw std::runtime_error(path + ": is a pipe or a device and cannot be read twice; save the " +
                             "data to a file first");
  }
}

std::ifstream openBinary(const std::string& path) {
  requireFile(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error(path + ": cannot be read (" + std::strerror(errno) +
                             "); check its permissions");
  }
  return file;
}

}  // namespace

std::string readMagic(const std::string& path, std::size_t count) {
  std::ifstream file = openBinary(path);
  std::string bytes(count, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

std::unique_ptr<std::istream> openText(const std::string& path) {
  const std::string magic = readMagic(path, kCompressionBytes);
  auto stream = std::make_unique<boost::iostreams::filtering_istream>();
  if (startsWith(magic, kBzip2Magic)) {
    stream->push(boost::iostreams::bzip2_decompressor());
  } else if (startsWith(magic, kGzipMagic)) {
    stream->push(boost::iostreams::gzip_decompressor());
  } else if (startsWith(magic, kXzMagic)) {
    stream->push(boost::iostreams::lzma_decompressor());
  }
  stream->push(boost::iostreams::file_source(path, std::ios::binary));
  return stream;
}

std::string readHead(const std::string& path, std::size_t bytes) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::string head;
  for (std::string line; head.size() < bytes && readLine(*stream, line);) {
    head += line + (stream->eof() ? "" : "\n");
  }
  return head;
}

bool readLine(std::istream& stream, std::string& line) {
  constexpr std::size_t kMaxLine = 1U << 24U;  // 16 MB; a scan with 100 000 beams has 1 MB
  line.clear();
  std::streambuf& buffer = *stream.rdbuf();
  const std::istream::sentry is_ready(stream, true);
  if (!is_ready) return false;
  try {
    for (int c = buffer.sbumpc(); c != '\n'; c = buffer.sbumpc()) {
      if (c == std::char_traits<char>::eof()) {
        stream.setstate(line.empty() ? std::ios::eofbit | std::ios::failbit : std::ios::eofbit);
        return !line.empty();
      }
      if (line.size() == kMaxLine) {
        stream.setstate(std::ios::badbit);
        return false;
      }
      line += static_cast<char>(c);
    }
  } catch (const std::exception&) {  // from the decompressor
    stream.setstate(std::ios::badbit);
    return false;
  }
  return true;
}

std::string cutOffText(std::size_t line) {
  return "the data are damaged or cut off after line " + std::to_string(line) +
         ": only the scans before it are used";
}

bool parseFinite(const std::string& text, double& value) {
  if (text.empty() || std::isspace(static_cast<unsigned char>(text.front())) != 0) return false;
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return end == text.c_str() + text.size() && std::isfinite(value);
}

}  // namespace kestrel
