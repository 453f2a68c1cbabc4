// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzzer.h"
#include "kestrel_slam/parameters/filter_parameters.h"
#include "kestrel_slam/parameters/parameters_yaml.h"

namespace kestrel::fuzz {

KESTREL_FUZZER(parameters, bytes) {
  const FuzzFile file(bytes);
  expectResultOrReason([&] {
    SlamConfig config;
    loadParameters(file.path(), config);
    validate(config);
  });
}

}  // namespace kestrel::fuzz
