// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// What an accelerometer at rest measures, m/s².
constexpr double kGravity = 9.81;

}  // namespace kestrel
