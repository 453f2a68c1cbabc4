// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// The version of the package, as in package.xml (a test compares them).
constexpr const char* kVersion = "0.2.0";

}  // namespace kestrel
