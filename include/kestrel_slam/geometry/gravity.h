// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel_slam {

/// What an accelerometer at rest measures, m/s².
constexpr double kGravity = 9.81;

}  // namespace kestrel_slam
