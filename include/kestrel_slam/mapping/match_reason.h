// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// Why a scan has its state, in a few words without commas. doc/tuning.md ("My map breaks") says
/// what to do for each of them. `config`: that of the mapper.
const char* reasonOf(const MapperResult& result, const MapperConfig& config);

}  // namespace kestrel
