// SPDX-License-Identifier: BSD-3-Clause
#include "page_data.h"

#include "kestrel_slam/report/map_image.h"

namespace kestrel {

using Json = nlohmann::ordered_json;

Json imageOf(const MapSnapshot& map) {
  const MapImage image = renderMap(map);
  return {{"png", "data:image/png;base64," + base64(image.png)},
          {"width", image.width},
          {"height", image.height},
          {"metersPerPixel", map.resolution_m * image.cells_per_pixel},
          {"originX", map.origin_x},
          {"originY", map.origin_y}};
}

std::string embedded(const Json& data) {
  std::string result;
  for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    result += c == '<' ? "\\u003c" : std::string(1, c);
  }
  return result;
}

}  // namespace kestrel
