// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>

namespace kestrel {

inline std::string numberText(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace kestrel
