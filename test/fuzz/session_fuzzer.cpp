// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_input.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel::fuzz {
namespace {

/// A file with right checksums and any contents: damage that gets through to the decoder.
std::string wrapped(const std::string& bytes) {
  static const char* const kTags[] = {"INFO", "SUBM", "GRAP", "KEYF", "WHAT"};
  FuzzInput input(bytes);
  ChunkWriter writer("fuzzer");
  while (!input.atEnd()) {
    const char* const tag = kTags[input.below(5)];
    std::string content(input.raw<std::uint16_t>() % 4096U, '\0');
    for (char& c : content) c = static_cast<char>(input.byte());
    writer.add(tag, 1, content);
  }
  return writer.finish();
}

void decode(const std::string& file) {
  expectResultOrReason([&] {
    const Session session = decodeSession(file);
    const std::string again = encodeSession(session);
    FUZZ_CHECK(encodeSession(decodeSession(again)) == again);
    keyframePoses(session);
    graphOf(session);
  });
  expectResultOrReason([&] {
    const RepairedSession repaired = repairSession(file);
    FUZZ_CHECK(problemOf(repaired.session).empty());
  });
}

}  // namespace

KESTREL_FUZZER(session, bytes) {
  decode(bytes);
  decode(wrapped(bytes));
}

}  // namespace kestrel::fuzz
