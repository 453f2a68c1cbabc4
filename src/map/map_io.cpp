// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_io.h"

#include <cmath>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <map>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/pgm.h"

namespace kestrel {
namespace {

// Gray values and thresholds of map_saver in map_server.
constexpr std::uint8_t kFreeGray = 254, kUnknownGray = 205, kOccupiedGray = 0;
constexpr double kOccupiedThreshold = 0.65, kFreeThreshold = 0.196;
constexpr double kWhite = 255.0;
constexpr int kShortDigits = 15, kExactDigits = 17;  // significant digits of a double

using Keys = std::map<std::string, std::string>;

std::string numberText(double value) {
  for (const int digits : {kShortDigits, kExactDigits}) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << std::setprecision(digits) << value;
    if (digits == kExactDigits || std::stod(text.str()) == value) return text.str();
  }
  return {};
}

std::uint8_t grayOf(std::int8_t cell) {
  if (cell == MapSnapshot::kFree) return kFreeGray;
  return cell == MapSnapshot::kUnknown ? kUnknownGray : kOccupiedGray;
}

/// The first row of the image is the upper one, the first row of the map the lower one.
GrayImage imageOf(const MapSnapshot& map) {
  GrayImage image{map.width, map.height, {}};
  image.pixels.reserve(map.cells.size());
  for (int row = map.height - 1; row >= 0; --row) {
    for (int column = 0; column < map.width; ++column) {
      image.pixels.push_back(grayOf(map.at(column, row)));
    }
  }
  return image;
}

std::string yamlOf(const MapSnapshot& map, const std::string& image_name) {
  std::ostringstream yaml;
  yaml << "image: " << image_name << "\nmode: trinary\nresolution: " << numberText(map.resolution_m)
       << "\norigin: [" << numberText(map.origin_x) << ", " << numberText(map.origin_y)
       << ", 0.0]\nnegate: 0\noccupied_thresh: " << numberText(kOccupiedThreshold)
       << "\nfree_thresh: " << numberText(kFreeThreshold) << "\n";
  return yaml.str();
}

std::string trimmed(const std::string& text) {
  const char* const blank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

/// The value without a trailing comment and without quotes.
std::string plainValue(const std::string& text) {
  const std::string value = trimmed(text);
  if (!value.empty() && (value[0] == '"' || value[0] == '\'')) {
    return value.substr(1, value.find(value[0], 1) - 1);
  }
  if (!value.empty() && value[0] == '#') return {};
  return trimmed(value.substr(0, value.find(" #")));
}

/// Parses the flat YAML of a map: one `key: value` per line, comments, and lists in brackets or as
/// `- item`.
Keys parseYaml(const std::string& text) {
  Keys keys;
  std::string key;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string content = trimmed(line);
    if (content.empty() || content[0] == '#' || content == "---") continue;
    if (content.rfind("- ", 0) == 0 && !key.empty()) {
      keys[key] += plainValue(content.substr(2)) + ",";
      continue;
    }
    const std::size_t colon = content.find(':');
    if (colon == std::string::npos) {
      throw std::runtime_error("the line '" + content + "' is not 'key: value'");
    }
    key = trimmed(content.substr(0, colon));
    keys[key] = plainValue(content.substr(colon + 1));
  }
  return keys;
}

const std::string& required(const Keys& keys, const std::string& key) {
  const auto found = keys.find(key);
  if (found == keys.end() || found->second.empty()) {
    throw std::runtime_error("the key '" + key + "' is missing; is this the YAML file of a map?");
  }
  return found->second;
}

double number(const std::string& key, const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  std::string rest;
  if (!(stream >> value) || stream >> rest || !std::isfinite(value)) {
    throw std::runtime_error("'" + key + "' is '" + text + "', not a number");
  }
  return value;
}

double numberWithin(const Keys& keys, const std::string& key, double min, double max) {
  const double value = number(key, required(keys, key));
  if (value < min || value > max) {
    throw std::runtime_error("'" + key + "' is " + numberText(value) + ", not within " +
                             numberText(min) + " to " + numberText(max));
  }
  return value;
}

void readOrigin(const Keys& keys, MapSnapshot& map) {
  std::string text = required(keys, "origin");
  for (char& c : text) {
    if (c == '[' || c == ']' || c == ',') c = ' ';
  }
  std::istringstream items(text);
  std::vector<double> values;
  for (std::string item; items >> item;) values.push_back(number("origin", item));
  constexpr std::size_t kOriginSize = 3;
  if (values.size() != kOriginSize) {
    throw std::runtime_error("'origin' is not a list of three numbers [x, y, yaw]");
  }
  if (values[2] != 0.0) {
    throw std::runtime_error("the map is rotated by a yaw of " + numberText(values[2]) +
                             " rad; only a yaw of 0 is supported");
  }
  map.origin_x = values[0];
  map.origin_y = values[1];
}

/// Converts gray values to cells as map_server does.
struct Classes {
  double occupied = kOccupiedThreshold;
  double free = kFreeThreshold;
  bool negate = false;

  std::int8_t cellOf(std::uint8_t gray) const {
    const double occupancy = (negate ? gray : kWhite - gray) / kWhite;
    if (occupancy > occupied) return MapSnapshot::kOccupied;
    return occupancy < free ? MapSnapshot::kFree : MapSnapshot::kUnknown;
  }
};

Classes readClasses(const Keys& keys) {
  const auto mode = keys.find("mode");
  if (mode != keys.end() && mode->second != "trinary" && mode->second != "scale") {
    throw std::runtime_error("the mode '" + mode->second + "' is not supported; use trinary");
  }
  Classes classes;
  classes.occupied = numberWithin(keys, "occupied_thresh", 0.0, 1.0);
  classes.free = numberWithin(keys, "free_thresh", 0.0, 1.0);
  if (classes.free > classes.occupied) {
    throw std::runtime_error("'free_thresh' is above 'occupied_thresh'");
  }
  const std::string& negate = required(keys, "negate");
  classes.negate = negate == "1" || negate == "true";
  if (!classes.negate && negate != "0" && negate != "false") {
    throw std::runtime_error("'negate' is '" + negate + "', not 0 or 1");
  }
  return classes;
}

void readCells(const std::string& image_path, const Classes& classes, MapSnapshot& map) {
  GrayImage image;
  const std::string bytes = readFile(image_path);
  try {
    image = decodePgm(bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("the image " + image_path + " cannot be read: " + error.what());
  }
  map.width = image.width;
  map.height = image.height;
  map.cells.reserve(image.pixels.size());
  const std::size_t width = static_cast<std::size_t>(image.width);
  for (std::size_t row = static_cast<std::size_t>(image.height); row-- > 0;) {
    for (std::size_t column = 0; column < width; ++column) {
      map.cells.push_back(classes.cellOf(image.pixels[row * width + column]));
    }
  }
}

}  // namespace

void writeMap(const std::string& stem, const MapSnapshot& map) {
  if (map.empty()) {
    throw std::runtime_error("cannot write " + stem + ".pgm: the map is still empty");
  }
  const std::filesystem::path image_path = stem + ".pgm";
  const std::string comment = "CREATOR: kestrel_slam " + numberText(map.resolution_m) + " m/pix";
  writeFileAtomically(image_path.string(), encodePgm(imageOf(map), comment));
  // The image is written first, so that it exists when a reader sees the new YAML file.
  writeFileAtomically(stem + ".yaml", yamlOf(map, image_path.filename().string()));
}

MapSnapshot readMap(const std::string& yaml_path) {
  const std::string text = readFile(yaml_path);
  try {
    const Keys keys = parseYaml(text);
    MapSnapshot map;
    constexpr double kMinResolution_m = 1e-4, kMaxResolution_m = 100.0;
    map.resolution_m = numberWithin(keys, "resolution", kMinResolution_m, kMaxResolution_m);
    readOrigin(keys, map);
    const Classes classes = readClasses(keys);
    // If the image path is absolute, the operator returns it unchanged.
    const auto image_path =
        std::filesystem::path(yaml_path).parent_path() / required(keys, "image");
    readCells(image_path.string(), classes, map);
    return map;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("cannot read the map " + yaml_path + ": " + error.what());
  }
}

}  // namespace kestrel
