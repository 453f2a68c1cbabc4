// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

inline constexpr double square(double x) { return x * x; }

}  // namespace kestrel
