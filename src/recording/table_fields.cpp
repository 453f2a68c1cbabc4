// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>

#include "table_layout.h"

namespace kestrel {
namespace {

constexpr const char* kBlanks = " \t\r";
constexpr std::ptrdiff_t kManyFields = 7;  // separators in a line with many fields

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> splitAtBlanks(std::string_view text) {
  std::vector<std::string_view> fields;
  for (std::size_t at = text.find_first_not_of(kBlanks); at < text.size();) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    fields.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kBlanks, end);
  }
  return fields;
}

std::vector<std::string_view> splitAt(char separator, std::string_view text) {
  std::vector<std::string_view> fields;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    fields.push_back(trimmed(text.substr(at, end - at)));
    at = end + 1;
  }
  if (!fields.empty() && fields.back().empty()) fields.pop_back();
  return fields;
}

/// True if each field between blanks is a number with a decimal comma, as in "4,003 4,009".
bool hasCommaInEachField(const std::string& line) {
  const std::vector<std::string_view> fields = splitAtBlanks(line);
  const auto has_one = [](std::string_view field) {
    return std::count(field.begin(), field.end(), ',') == 1 && field.back() != ',';
  };
  return fields.size() > static_cast<std::size_t>(kManyFields) &&
         std::all_of(fields.begin(), fields.end(), has_one);
}

}  // namespace

bool isBlank(const std::string& line) {
  return line.find_first_not_of(kBlanks) == std::string::npos;
}

TableFormat formatOf(const std::string& line) {
  const auto count = [&line](char c) { return std::count(line.begin(), line.end(), c); };
  const bool has_commas = count(',') > 0;
  if (count(';') >= kManyFields) return {';', has_commas};
  if (count('\t') >= kManyFields) return {'\t', has_commas && line.find(",\t") == line.npos};
  if (hasCommaInEachField(line)) return {' ', true};
  return {count(',') >= kManyFields ? ',' : ' ', false};
}

std::vector<std::string_view> fieldsOf(const std::string& line, const TableFormat& format) {
  return format.separator == ' ' ? splitAtBlanks(line) : splitAt(format.separator, line);
}

bool parseField(std::string_view field, const TableFormat& format, double& value) {
  std::string text(field);
  if (format.decimal_comma) std::replace(text.begin(), text.end(), ',', '.');
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return !text.empty() && end == text.c_str() + text.size();
}

}  // namespace kestrel
