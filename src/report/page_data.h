// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// The map as a picture inside a page, with its place in the map frame.
nlohmann::ordered_json imageOf(const MapSnapshot& map);

/// JSON that is safe inside a script element. It escapes '<', because "</script>" in a file name
/// would end the element.
std::string embedded(const nlohmann::ordered_json& data);

}  // namespace kestrel
