// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/map/map_io.h"

namespace kestrel::fuzz {

// The image is always the same, and the YAML file must not name other files of this computer.
KESTREL_FUZZER(map_yaml, bytes) {
  if (bytes.find("image") != std::string::npos) return;
  const FuzzFile image("P2 3 2 100 0 20 100 100 20 0");
  const FuzzFile yaml("image: " + image.path() + "\n" + bytes);
  expectResultOrReason([&] {
    const MapSnapshot map = readMap(yaml.path());
    FUZZ_CHECK(map.cells.size() == 6 && map.resolution_m > 0.0);
    FUZZ_CHECK(std::isfinite(map.origin_x) && std::isfinite(map.origin_y));
  });
}

}  // namespace kestrel::fuzz
