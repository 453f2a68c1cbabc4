// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>

namespace kestrel {

/// Processor time of this program so far, s.
inline double processorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace kestrel
