// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/map/pgm.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(pgm, bytes) {
  expectResultOrReason([&] {
    const GrayImage image = decodePgm(bytes);
    const auto pixels =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    FUZZ_CHECK(image.pixels.size() == pixels);
    FUZZ_CHECK(decodePgm(encodePgm(image, "again")).pixels == image.pixels);
  });
}

}  // namespace kestrel::fuzz
