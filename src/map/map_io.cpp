// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_io.h"

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/pgm.h"
#include "map_files.h"
#include "map_yaml.h"
#include "output_folder.h"

namespace kestrel {
namespace {

// Gray values and thresholds of map_saver in map_server.
constexpr std::uint8_t kFreeGray = 254, kUnknownGray = 205, kOccupiedGray = 0;
constexpr double kOccupiedThreshold = 0.65, kFreeThreshold = 0.196;
constexpr double kLightest = 255.0, kRawOccupied = 100.0;
constexpr const char* kSavingEnding = ".pgm.saving";
constexpr int kMaxTries = 10;  // a process that writes may be faster than one that reads
constexpr double kMostRotatedCells = 4e8;            // a narrow image may need very many
constexpr int kShortDigits = 15, kExactDigits = 17;  // significant digits of a double

using Keys = YamlKeys;

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
  yaml << "image: " << yamlFileName(image_name)
       << "\nmode: trinary\nresolution: " << numberText(map.resolution_m) << "\norigin: ["
       << numberText(map.origin_x) << ", " << numberText(map.origin_y)
       << ", 0.0]\nnegate: 0\noccupied_thresh: " << numberText(kOccupiedThreshold)
       << "\nfree_thresh: " << numberText(kFreeThreshold) << "\n";
  return yaml.str();
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

/// Returns the yaw of the image in the map.
double readOrigin(const Keys& keys, MapSnapshot& map) {
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
  map.origin_x = values[0];
  map.origin_y = values[1];
  return values[2];
}

/// The image is rotated by `yaw` around its corner. In the result the axes are those of the map;
/// each of its cells is the cell of the image at its center.
MapSnapshot upright(const MapSnapshot& image, double yaw) {
  const Pose2 map_T_image(image.origin_x, image.origin_y, yaw);
  const double cell = image.resolution_m, width = cell * image.width, height = cell * image.height;
  Eigen::AlignedBox2d box;
  for (const double x : {0.0, width}) {
    for (const double y : {0.0, height}) box.extend(map_T_image * Eigen::Vector2d(x, y));
  }
  MapSnapshot result;
  result.resolution_m = cell;
  result.origin_x = box.min().x();
  result.origin_y = box.min().y();
  result.width = static_cast<int>(std::ceil(box.sizes().x() / cell));
  result.height = static_cast<int>(std::ceil(box.sizes().y() / cell));
  if (static_cast<double>(result.width) * result.height > kMostRotatedCells)
    throw std::runtime_error("its rotated image is too large");
  const Pose2 image_T_map = map_T_image.inverse();
  for (int row = 0; row < result.height; ++row) {
    for (int column = 0; column < result.width; ++column) {
      const Eigen::Vector2d center = box.min() + cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      const Eigen::Vector2d at = (image_T_map * center) / cell;
      const bool inside = at.minCoeff() >= 0.0 && at.x() < image.width && at.y() < image.height;
      result.cells.push_back(inside ? image.at(static_cast<int>(at.x()), static_cast<int>(at.y()))
                                    : MapSnapshot::kUnknown);
    }
  }
  return result;
}

/// Converts gray values to cells as map_server does.
struct Classes {
  double occupied = kOccupiedThreshold;
  double free = kFreeThreshold;
  bool negate = false, raw = false;

  /// In the mode raw, the values 0 to 100 are the occupancy in percent.
  std::int8_t cellOf(std::uint8_t gray) const {
    const double dark = negate ? gray : kLightest - gray;
    if (raw && kLightest - dark > kRawOccupied) return MapSnapshot::kUnknown;
    const double occupancy = raw ? (kLightest - dark) / kRawOccupied : dark / kLightest;
    if (occupancy > occupied) return MapSnapshot::kOccupied;
    return occupancy < free ? MapSnapshot::kFree : MapSnapshot::kUnknown;
  }
};

Classes readClasses(const Keys& keys) {
  const auto mode = keys.find("mode");
  Classes classes;
  classes.raw = mode != keys.end() && mode->second == "raw";
  if (mode != keys.end() && mode->second != "trinary" && mode->second != "scale" && !classes.raw) {
    throw std::runtime_error("the mode is '" + mode->second + "', not trinary, scale or raw");
  }
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

MapSnapshot mapOf(const std::string& yaml_path, const std::string& text) {
  const Keys keys = parseMapYaml(text);
  MapSnapshot map;
  constexpr double kMinResolution_m = 1e-4, kMaxResolution_m = 100.0;
  map.resolution_m = numberWithin(keys, "resolution", kMinResolution_m, kMaxResolution_m);
  const double yaw = readOrigin(keys, map);
  const Classes classes = readClasses(keys);
  // If the image path is absolute, the operator returns it unchanged.
  const auto image_path = std::filesystem::path(yaml_path).parent_path() / required(keys, "image");
  readCells(image_path.string(), classes, map);
  return yaw == 0.0 ? map : upright(map, yaw);
}

/// The image that the YAML file names, or "" where there is no file or none that can be read.
std::string imageNamedBy(const std::string& yaml_path) {
  try {
    return parseMapYaml(readFile(yaml_path))["image"];
  } catch (const std::runtime_error&) {
    return {};
  }
}

}  // namespace

MapFiles mapFilesOf(const std::string& stem, const MapSnapshot& map) {
  if (map.empty()) {
    throw std::runtime_error("cannot write " + stem + ".pgm: the map is still empty");
  }
  const std::string name = std::filesystem::path(stem).filename().string();
  const std::string comment = "CREATOR: kestrel_slam " + numberText(map.resolution_m) + " m/pix";
  return {encodePgm(imageOf(map), comment), yamlOf(map, name + ".pgm"),
          yamlOf(map, name + kSavingEnding)};
}

std::set<std::string> namesOfMap(const std::string& name) {
  return {name + ".pgm", name + ".yaml", name + kSavingEnding};
}

void writeMapFiles(OutputFolder& folder, const std::string& name, const MapFiles& files) {
  const std::string yaml = name + ".yaml", image = name + ".pgm", saving = name + kSavingEnding;
  for (const std::string& file : namesOfMap(name)) folder.requireReplaceable(file);
  // While an older YAML file names the image, the image must not be replaced. So the new YAML file
  // first names a second copy. A process that was killed may have left it like that.
  const bool in_use = imageNamedBy(folder.pathOf(yaml)) == saving;
  if (folder.has(yaml) && !in_use) {
    folder.write(saving, files.image);
    folder.write(yaml, files.yaml_while_saving);
  }
  folder.write(image, files.image);
  folder.write(yaml, files.yaml);
  folder.remove(saving);
}

void writeMap(const std::string& stem, const MapSnapshot& map) {
  const std::filesystem::path path(stem);
  const std::string name = path.filename().string();
  if (name.empty()) throw std::runtime_error("cannot write '" + stem + "': it does not name a map");
  const MapFiles files = mapFilesOf(stem, map);
  OutputFolder folder(path.parent_path().string());
  writeMapFiles(folder, name, files);
}

MapSnapshot readMap(const std::string& yaml_path) {
  // The map may be saved again while it is read. Then its YAML file has changed.
  for (int tries = kMaxTries;; --tries) {
    const std::string text = readFile(yaml_path);
    try {
      MapSnapshot map = mapOf(yaml_path, text);
      if (tries == 1 || readFile(yaml_path) == text) return map;
    } catch (const std::runtime_error& error) {
      if (tries > 1 && readFile(yaml_path) != text) continue;
      throw std::runtime_error("cannot read the map " + yaml_path + ": " + error.what());
    }
  }
}

}  // namespace kestrel
