#include "kestrel_slam/mapping/parameters.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <locale>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace kestrel_slam {
namespace {

/// Longest piece of a user's text that a message repeats.
constexpr std::size_t kMaxQuotedLength = 60;

Parameter number(const char* name, const char* unit,
                 std::variant<double*, int*, bool*, std::string*> value, double min, double max,
                 const char* description) {
  return {name, unit, description, value, min, max, {}};
}

Parameter flag(const char* name, bool* value, const char* description) {
  return {name, "", description, value, 0.0, 0.0, {}};
}

Parameter choice(const char* name, std::string* value, std::vector<std::string> choices,
                 const char* description) {
  return {name, "", description, value, 0.0, 0.0, std::move(choices)};
}

std::string format(double value, int digits) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(digits);
  text << value;
  return text.str();
}

/// A number that is the whole text; independent of the locale, unlike strtod.
std::optional<double> parseDouble(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  if (!(stream >> std::noskipws >> value) ||
      stream.peek() != std::istringstream::traits_type::eof())
    return std::nullopt;
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<int> parseInt(const std::string& text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

std::optional<bool> parseBool(const std::string& text) {
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  return std::nullopt;
}

/// The shortest decimal text that reads back as exactly `value`.
std::string shortestText(double value) {
  for (int digits = std::numeric_limits<double>::digits10;
       digits < std::numeric_limits<double>::max_digits10; ++digits) {
    const std::string text = format(value, digits);
    if (parseDouble(text) == value) return text;
  }
  return format(value, std::numeric_limits<double>::max_digits10);
}

std::string limitsText(const Parameter& parameter) {
  return "between " + shortestText(parameter.min) + " and " + shortestText(parameter.max) +
         (parameter.unit.empty() ? "" : " " + parameter.unit);
}

/// What a user wrote, fit for one line of a message.
std::string oneLine(const std::string& text) {
  std::string result = text.substr(0, kMaxQuotedLength);
  for (char& c : result) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  if (text.size() > kMaxQuotedLength) result += "...";
  return result;
}

[[noreturn]] void refuse(const Parameter& parameter, const std::string& text,
                         const std::string& requirement) {
  throw std::invalid_argument(parameter.name + " = " + (text.empty() ? "''" : oneLine(text)) +
                              ": must be " + requirement);
}

bool isWithin(const Parameter& parameter, double value) {
  return value >= parameter.min && value <= parameter.max;  // false for NaN
}

template <typename T>
void assignNumber(const Parameter& parameter, T* target, const std::optional<T>& value,
                  const std::string& text, const std::string& kind) {
  if (!value) refuse(parameter, text, kind + " " + limitsText(parameter));
  if (!isWithin(parameter, static_cast<double>(*value))) {
    refuse(parameter, text, limitsText(parameter));
  }
  *target = *value;
}

void checkChoice(const Parameter& parameter, const std::string& text) {
  const auto& choices = parameter.choices;
  if (choices.empty()) return;
  if (std::find(choices.begin(), choices.end(), text) != choices.end()) return;
  std::string list;
  for (const std::string& allowed : choices) list += (list.empty() ? "" : ", ") + allowed;
  refuse(parameter, text, "one of " + list);
}

/// Parses, checks and stores the text of one parameter, according to the type of its place.
struct Assignment {
  const Parameter& parameter;
  const std::string& text;

  void operator()(double* target) const {
    assignNumber(parameter, target, parseDouble(text), text, "a number");
  }
  void operator()(int* target) const {
    assignNumber(parameter, target, parseInt(text), text, "a whole number");
  }
  void operator()(bool* target) const {
    const std::optional<bool> value = parseBool(text);
    if (!value) refuse(parameter, text, "true or false");
    *target = *value;
  }
  void operator()(std::string* target) const {
    checkChoice(parameter, text);
    *target = text;
  }
};

struct ValueText {
  std::string operator()(const double* value) const { return shortestText(*value); }
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const { return *value; }
};

/// Levenshtein distance: insertions, deletions and replacements that turn `a` into `b`.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0U : 1U);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

void requireLess(const char* name_a, double a, const char* name_b, double b) {
  if (a < b) return;
  throw std::invalid_argument(std::string(name_a) + " = " + shortestText(a) +
                              ": must be less than " + name_b + " = " + shortestText(b));
}

}  // namespace

std::vector<Parameter> parametersOf(SlamConfig& config) {
  BeamFilterConfig& beams = config.beams;
  MapperConfig& mapper = config.mapper;
  OccupancyGridConfig& grid = mapper.grid;
  // Columns: name, unit, place, smallest, largest, description.
  return {
      number("map_resolution", "m", &grid.resolution_m, 0.005, 1.0, "edge length of a map cell"),
      number("update_factor_free", "", &grid.miss_probability, 0.01, 0.49,
             "probability that a cell is occupied although a beam passed it"),
      number("update_factor_occupied", "", &grid.hit_probability, 0.51, 0.99,
             "probability that a cell is occupied where a beam ended in it"),
      number("map_min_probability", "", &grid.min_probability, 0.0001, 0.49,
             "lower clamp: how sure a cell can become that it is free"),
      number("map_max_probability", "", &grid.max_probability, 0.51, 0.9999,
             "upper clamp: how sure a cell can become that it is occupied"),
      number("map_memory_limit_mb", "MB", &grid.memory_limit_mb, 1.0, 1e6,
             "the map stops growing at this size, with a warning"),
      number("map_update_distance_thresh", "m", &mapper.insert_distance_m, 0.0, 100.0,
             "a scan enters the map after this much motion"),
      number("map_update_angle_thresh", "rad", &mapper.insert_angle_rad, 0.0, 100.0,
             "a scan enters the map after this much rotation"),
      number("laser_min_dist", "m", &beams.min_range_m, 0.0, 100.0,
             "closer returns are ignored: the vehicle itself"),
      number("laser_max_dist", "m", &beams.max_range_m, 0.1, 1000.0,
             "farther returns only clear free space"),
      number("clear_range", "m", &beams.clear_range_m, 0.0, 1000.0,
             "a beam without a return clears free space up to here; 0: not at all"),
      number("max_beams", "", &beams.max_beams, 1.0, 1e7, "scans with more beams are refused"),
      number("lost_score", "", &mapper.lost_score, 0.0, 1.0,
             "a scan whose best fit is below this is lost and not inserted"),
      number("search_score", "", &mapper.matcher.search_score, 0.0, 1.0,
             "a fit below this is degraded and starts the exhaustive search"),
      number("good_score", "", &mapper.matcher.good_score, 0.0, 1.0,
             "a fit below this is compared with that from other starts"),
      number("search_window", "m", &mapper.matcher.near_window.linear_m, 0.0, 10.0,
             "the exhaustive search looks this far in x and y"),
      number("search_angle", "rad", &mapper.matcher.near_window.angular_rad, 0.0, 3.15,
             "the exhaustive search looks this far in heading"),
      number("wide_search_window", "m", &mapper.matcher.wide_window.linear_m, 0.0, 10.0,
             "where that finds nothing good: this far in x and y"),
      number("wide_search_angle", "rad", &mapper.matcher.wide_window.angular_rad, 0.0, 3.15,
             "where that finds nothing good: this far in heading"),
      number("match_iterations", "", &mapper.matcher.gauss_newton.max_iterations, 1.0, 1000.0,
             "Gauss-Newton iterations of each resolution at most"),
      flag("use_evaluation_function", &mapper.evaluation.enabled,
           "judge by the penalised evaluation function whether a scan may enter the map"),
      number("evaluation_threshold", "", &mapper.evaluation.threshold, 1.0, 1000.0,
             "scans whose evaluation is above this stay out of the map"),
      number("evaluation_penalty", "", &mapper.evaluation.penalty, 0.0, 1000.0,
             "weight of the disagreement between the resolutions in the evaluation"),
      choice("matcher", &mapper.matcher.method, {"gauss_newton", "correlative", "hybrid"},
             "how the pose of a scan is found"),
  };
}

std::string valueText(const Parameter& parameter) {
  return std::visit(ValueText{}, parameter.value);
}

void setValue(const Parameter& parameter, const std::string& text) {
  std::visit(Assignment{parameter, text}, parameter.value);
}

void setParameter(SlamConfig& config, const std::string& name, const std::string& text) {
  for (const Parameter& parameter : parametersOf(config)) {
    if (parameter.name != name) continue;
    setValue(parameter, text);
    return;
  }
  throw std::invalid_argument("unknown parameter '" + oneLine(name) + "'; did you mean '" +
                              nearestParameterName(name) + "'?");
}

std::string nearestParameterName(const std::string& name) {
  SlamConfig config;
  std::vector<std::string> names;
  for (const Parameter& parameter : parametersOf(config)) names.push_back(parameter.name);
  return nearestName(name, names);
}

std::string nearestName(const std::string& name, const std::vector<std::string>& names) {
  const auto nearer = [&name](const std::string& a, const std::string& b) {
    return editDistance(a, name) < editDistance(b, name);
  };
  return *std::min_element(names.begin(), names.end(), nearer);
}

void validate(const SlamConfig& config) {
  // Setting every value to itself applies each parameter's own limits to configs made in code.
  SlamConfig copy = config;
  for (const Parameter& parameter : parametersOf(copy)) {
    setParameter(copy, parameter.name, valueText(parameter));
  }
  requireLess("laser_min_dist", config.beams.min_range_m, "laser_max_dist",
              config.beams.max_range_m);
  requireLess("map_min_probability", config.mapper.grid.min_probability, "map_max_probability",
              config.mapper.grid.max_probability);
}

}  // namespace kestrel_slam
