// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel {

/// The item called `name`. Throws std::invalid_argument, which lists the valid names. `kind` says
/// in the message what the items are.
template <typename T>
const T& findByName(const std::vector<T>& items, const std::string& kind, const std::string& name) {
  std::string names;
  for (const T& item : items) {
    if (item.name == name) return item;
    names += (names.empty() ? "" : ", ") + item.name;
  }
  throw std::invalid_argument("unknown " + kind + " '" + name + "'; known: " + names);
}

}  // namespace kestrel
