// SPDX-License-Identifier: BSD-3-Clause
#include "file_bytes.h"

#include <xxhash.h>
#include <zlib.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace kestrel {
namespace {

/// Fast: a session is saved in flight. Higher levels give 3 % shorter files and need twice the
/// time.
constexpr int kLevel = 4;

constexpr std::uint64_t kBlockBytes = 1U << 18U;

struct StreamEnd {
  void operator()(z_stream* stream) const { inflateEnd(stream); }
};

}  // namespace

std::uint64_t checksumOf(const std::string& bytes, std::uint64_t offset, std::uint64_t length) {
  return checksumOf(bytes, offset, length, 0, 0);
}

std::uint64_t checksumOf(const std::string& bytes, std::uint64_t offset, std::uint64_t length,
                         std::uint64_t next_offset, std::uint64_t next_length) {
  const std::unique_ptr<XXH64_state_t, XXH_errorcode (*)(XXH64_state_t*)> state(XXH64_createState(),
                                                                                XXH64_freeState);
  XXH64_reset(state.get(), 0);
  XXH64_update(state.get(), bytes.data() + offset, length);
  XXH64_update(state.get(), bytes.data() + next_offset, next_length);
  return XXH64_digest(state.get());
}

std::string pack(const std::string& content) {
  uLongf length = compressBound(static_cast<uLong>(content.size()));
  std::string packed(length, '\0');
  const int result =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &length,
                reinterpret_cast<const Bytef*>(content.data()), content.size(), kLevel);
  if (result != Z_OK) throw std::runtime_error("zlib cannot pack a chunk: not enough memory");
  packed.resize(length);
  return packed;
}

std::string unpack(const char* packed, std::size_t packed_bytes, std::uint64_t content_bytes) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::runtime_error("zlib has not enough memory");
  const std::unique_ptr<z_stream, StreamEnd> ends(&stream);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed));
  stream.avail_in = static_cast<uInt>(packed_bytes);
  std::string content;
  int result = Z_OK;
  // The last round has no room: it is only there to see the end of the stream.
  while (result == Z_OK) {
    const std::uint64_t done = content.size();
    const std::uint64_t room = std::min(kBlockBytes, content_bytes - done);
    content.resize(done + std::max<std::uint64_t>(room, 1));
    stream.next_out = reinterpret_cast<Bytef*>(content.data() + done);
    stream.avail_out = static_cast<uInt>(std::max<std::uint64_t>(room, 1));
    result = inflate(&stream, Z_NO_FLUSH);
    content.resize(stream.total_out);
    if (content.size() > content_bytes) break;
  }
  if (result != Z_STREAM_END || content.size() != content_bytes || stream.avail_in != 0) {
    throw std::runtime_error("its content cannot be unpacked");
  }
  return content;
}

}  // namespace kestrel
