// SPDX-License-Identifier: BSD-3-Clause
#include <istream>

#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(text_stream, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    readHead(file.path());
    const auto stream = openText(file.path());
    for (std::string line; std::getline(*stream, line);) {
    }
  });
}

}  // namespace kestrel::fuzz
