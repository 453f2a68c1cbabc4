// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// The smallest multiple of `unit` that is not less than `value`; for positive numbers.
inline constexpr int roundUp(int value, int unit) { return (value + unit - 1) / unit * unit; }

}  // namespace kestrel
